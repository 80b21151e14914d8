//! Palletizing, for real: bins of both orientations end upright in their places, and only those
//! that arrived upside down went over the jig.

use std::f64::consts::FRAC_PI_2;

use cell_model::cells::script::parse_for;
use cell_sim::{OneProcess, eval::template};
use ipc_types::decision::Outcome;
use ipc_types::world::{OBJECT_ENABLED, ObjectState};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// One of its first two bins arrives upside down.
const SEED: u64 = 4;
/// From a bin's middle up to the inside of its floor (m).
const BIN_FLOOR_M: f64 = 0.005 - 0.135 / 2.0;
const SLOTS: [[f64; 2]; 2] = [[1.05, -0.62], [1.05, -0.31]];

struct Run {
    sim: OneProcess,
    lines: Vec<String>,
    /// By bin: how it lay when it was seen first.
    upside_down: Vec<Option<bool>>,
}

fn up(object: &ObjectState) -> f64 {
    let [w, x, y, z] = object.pose.orientation_wxyz;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    (turn * Vector3::z()).z
}

impl Run {
    fn new(bins: u32) -> Self {
        Self::with_script(bins, SEED, "")
    }

    fn with_script(bins: u32, seed: u64, script: &str) -> Self {
        let mut spec = template("ur10-palletize", "table");
        spec.seed = seed;
        spec.bins = Some(bins);
        spec.time_limit_s = Some(60.0 * f64::from(bins));
        let cell = spec
            .load_cell_from(&cell_model::Data::checkout())
            .expect("the built-in cell");
        spec.script = parse_for(script, "test", &cell).expect("a script");
        let sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
        let upside_down = vec![None; bins as usize];
        Self {
            sim,
            lines: Vec::new(),
            upside_down,
        }
    }

    fn tick(&mut self) -> bool {
        let goes_on = self.sim.tick().expect("a tick");
        let objects = self.sim.state().objects().iter();
        for (lie, object) in self.upside_down.iter_mut().zip(objects) {
            if lie.is_none() && object.flags & OBJECT_ENABLED != 0 {
                *lie = Some(up(object) < 0.0);
            }
        }
        let trace = self.sim.take_trace().into_iter();
        self.lines.extend(trace.map(|(_, line)| line));
        goes_on
    }

    fn said(&self, words: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(words)).count()
    }
}

#[test]
fn bins_of_both_lies_end_upright_in_their_places() {
    let mut run = Run::new(2);
    while run.tick() {}
    let decision = run.sim.decision();
    let outcome = Outcome::from_code(decision.outcome);
    assert_eq!(outcome, Some(Outcome::Done), "{:#?}", run.lines);
    assert_eq!((decision.drops, decision.recoveries), (0, 0));
    let placed = &decision.placed[..decision.placed_count as usize];
    assert_eq!(placed, [0, 1]);
    let came = &run.upside_down;
    assert!(came.contains(&Some(true)) && came.contains(&Some(false)));
    for (bin, [x, y]) in SLOTS.into_iter().enumerate() {
        let object = &run.sim.state().objects()[bin];
        let [at_x, at_y, _] = object.pose.position;
        let off = (at_x - x).hypot(at_y - y);
        assert!(off < 0.02, "bin {bin} is {off} m off its place");
        assert!(up(object) > 0.999);
        let speed = Vector3::from(object.twist.linear).norm();
        assert!(speed < 1.0e-3, "bin {bin} moves at {speed} m/s");
        let flips = run.said(&format!("<flip> bin_{:02}", bin + 1));
        assert_eq!(Some(flips == 1), run.upside_down[bin]);
    }
    assert_eq!(run.sim.state().arms()[0].limit_violations, 0);
}

#[test]
fn a_task_killed_again_and_again_changes_nothing() {
    let mut plain = Run::new(1);
    while plain.tick() {}
    let mut killed = Run::new(1);
    while killed.tick() {
        // No whole number of decisions, so that every step meets it.
        if killed.sim.state().header.tick.is_multiple_of(997) {
            killed.sim.restart_task().expect("a new task");
        }
    }
    assert!(killed.sim.task_restarts() > 10);
    let hash = |run: &Run| run.sim.state().state_hash;
    assert_eq!(hash(&plain), hash(&killed));
}

/// The belt stops for anything that takes bins from its end, a task or a hand: against the
/// stop beyond it a bin jams, and shears a cup off.
#[test]
fn a_bin_that_comes_in_a_pause_stops_where_a_hand_can_grip_it() {
    const PAUSE: &str = "{\"at_s\":3,\"do\":\"task_pause\"}\n";
    let at_10_s = |script: &str| {
        // By its seed the bin opens upward.
        let mut run = Run::with_script(1, 1, script);
        while run.tick() && run.sim.state().header.tick < 10_000 {}
        run
    };
    let waiting = at_10_s(PAUSE).sim.state().objects()[0];
    let [x, y, z] = waiting.pose.position;
    assert!((0.37..0.4).contains(&y), "it lies at y = {y}");
    let [w, i, j, k] = waiting.pose.orientation_wxyz;
    let lies = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    // The cup, along x of its frame, points down; it ends 2 mm above the floor.
    let turn = lies * UnitQuaternion::from_euler_angles(0.0, FRAC_PI_2, -FRAC_PI_2);
    let lead = |at_s: f64, z: f64| {
        format!(
            "{{\"at_s\":{at_s},\"do\":\"target\",\"position\":[{x},{y},{z}],\
             \"orientation_wxyz\":[{},{},{},{}]}}\n",
            turn.w, turn.i, turn.j, turn.k
        )
    };
    let script = [
        PAUSE,
        &lead(5.0, z + 0.3),
        &lead(7.0, z + BIN_FLOOR_M + 0.002),
        "{\"at_s\":9,\"do\":\"gripper\",\"to\":\"close\"}\n",
        &lead(9.5, z + 0.3),
    ];
    let lifted = at_10_s(&script.concat());
    let gripper = &lifted.sim.state().arms()[0].gripper;
    assert_eq!((gripper.attached, gripper.breaks), (1, 0), "{gripper:?}");
    let height = lifted.sim.state().objects()[0].pose.position[2];
    assert!(height > z + 0.1, "it is at {height} m");
}

/// Where the straight way to the pallet passes the arm's own base, and motion policies alone stop
/// short of it: a planned path leads the arm around.
#[test]
fn a_bin_the_operator_led_to_the_far_side_still_comes_to_its_place() {
    for [x, y, z] in [[0.6, 0.0, 0.5], [0.7, 0.3, 0.3]] {
        let script = format!(
            "{{\"at_s\":9,\"do\":\"task_pause\"}}\n\
             {{\"at_s\":9.5,\"do\":\"target\",\"position\":[{x},{y},{z}],\
             \"orientation_wxyz\":[0,1,0,0]}}\n\
             {{\"at_s\":12,\"do\":\"task_resume\"}}\n"
        );
        let mut run = Run::with_script(1, 1, &script);
        while run.tick() {}
        let decision = run.sim.decision();
        let outcome = Outcome::from_code(decision.outcome);
        assert_eq!(outcome, Some(Outcome::Done), "{:#?}", run.lines);
        assert_eq!((decision.drops, decision.placed_count), (0, 1));
        assert_eq!(run.said("[missed] bin_01: ReachToPlace"), 0);
        assert_eq!(run.sim.state().arms()[0].limit_violations, 0);
    }
}
