//! An operator with any action at any moment. `ROBOCELL_OPERATOR=N` asks for N actions in each
//! demo.

use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::validate::Validate;
use ipc_types::{OperatorRequest, Pose, WorldState};

const ACTIONS: [OperatorAction; 14] = [
    OperatorAction::Pause,
    OperatorAction::Resume,
    OperatorAction::Resume,
    OperatorAction::Step,
    OperatorAction::Reset,
    OperatorAction::Drag,
    OperatorAction::Target,
    OperatorAction::Gripper,
    OperatorAction::TaskStart,
    OperatorAction::TaskPause,
    OperatorAction::TaskResume,
    OperatorAction::TaskReset,
    OperatorAction::DropParts,
    OperatorAction::AddBin,
];

struct Random(u64);

impl Random {
    fn below(&mut self, count: u32) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u32::try_from((self.0 >> 33) % u64::from(count)).unwrap()
    }

    /// From -1 to 1.
    fn share(&mut self) -> f64 {
        f64::from(self.below(2_000_001)) / 1.0e6 - 1.0
    }

    fn pose(&mut self) -> Pose {
        // Mostly where an arm can reach, sometimes where nothing is.
        let reach = [1.0, 1.0, 1.0, 30.0][self.below(4) as usize];
        let position = [(); 3].map(|()| reach * self.share());
        let turn = [(); 4].map(|()| self.share());
        let norm = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
        Pose {
            position,
            orientation_wxyz: turn.map(|x| x / norm),
        }
    }

    fn request(&mut self) -> OperatorRequest {
        let action = ACTIONS[self.below(14) as usize];
        let counts = match action {
            OperatorAction::Gripper => 3,
            OperatorAction::Step => 300,
            _ => 4,
        };
        OperatorRequest {
            action: action.code(),
            object: self.below(8),
            arm: self.below(3),
            count: self.below(counts),
            pose: self.pose(),
            seconds: 2.0 * self.share().abs(),
            ..OperatorRequest::zeroed_at_identity()
        }
    }
}

fn check(state: &WorldState, what: &str) {
    state
        .validate()
        .unwrap_or_else(|why| panic!("{what}: {why}"));
    for arm in state.arms() {
        assert_eq!((arm.limit_violations, arm.fault), (0, 0), "{what}");
    }
}

fn anything_at_any_moment(demo: &str, policy: &str) {
    let asked = std::env::var("ROBOCELL_OPERATOR").ok();
    let count = asked.and_then(|text| text.parse().ok()).unwrap_or(60);
    let mut spec = template(demo, policy);
    spec.time_limit_s = Some(1.0e6);
    let cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
    let (mut random, mut accepted) = (Random(11), 0);
    for number in 0..count {
        let request = random.request();
        if request.validate().is_err() {
            // The bus refuses it before anybody sees it.
            continue;
        }
        let reply = sim.answer_request(&request);
        reply.validate().unwrap();
        accepted += u32::from(reply.code == ReplyCode::Accepted.code());
        for _ in 0..random.below(600) {
            // Time may be paused.
            sim.tick().unwrap();
            let what = format!("{demo}, action {number} ({:?})", request.action);
            check(sim.state(), &what);
        }
    }
    assert!(accepted > count / 3, "{demo}: {accepted} of {count}");
}

#[test]
fn of_the_cubes_breaks_no_limit() {
    anything_at_any_moment("franka-stack", "fsm");
}

#[test]
fn of_the_pyramid_breaks_no_limit() {
    anything_at_any_moment("franka-pyramid", "json");
}

#[test]
fn of_the_pallet_breaks_no_limit() {
    anything_at_any_moment("ur10-palletize", "table");
}

#[test]
fn of_the_filled_bin_breaks_no_limit() {
    anything_at_any_moment("ur10-fill-bin", "matrix");
}

#[test]
fn of_the_stacked_bins_breaks_no_limit() {
    anything_at_any_moment("ur10-bin-stack", "matrix");
}
