//! A controller that is made again from its record, again and again, computes to
//! the last bit what one that lives on computes.

use cell_model::Cell;
use cell_sim::{OneProcess, eval};
use controller_proc::cycle::Cycle;
use ipc_types::tap::KEYFRAME_BYTES;
use ipc_types::{ArmCommand, ArmStatus, DECISION_TICKS, Decision, Wire, WorldState};

/// Two controllers of one arm with the same inputs.
struct Pair {
    arm: usize,
    lasting: Cycle,
    renewed: Cycle,
    answers: [(ArmCommand, ArmStatus); 2],
}

impl Pair {
    fn new(cell: &Cell, arm: usize) -> Self {
        let cycle = || Cycle::new(cell, arm).expect("a controller");
        let answers = (ArmCommand::zeroed(), ArmStatus::zeroed());
        Self {
            arm,
            lasting: cycle(),
            renewed: cycle(),
            answers: [answers; 2],
        }
    }

    fn renew(&mut self, cell: &Cell) {
        let mut bytes = vec![0; KEYFRAME_BYTES];
        let length = self.renewed.save(30, &mut bytes).expect("room");
        self.renewed = Cycle::new(cell, self.arm).expect("a controller");
        let limit = self.renewed.restore(&bytes[..length]);
        assert_eq!(limit, Ok(30));
        // Nothing of what was written before is needed.
        self.answers[1] = (ArmCommand::zeroed(), ArmStatus::zeroed());
    }

    fn update(&mut self, state: &WorldState, decision: Option<&Decision>) {
        let cycles = [&mut self.lasting, &mut self.renewed];
        for (cycle, (command, status)) in cycles.into_iter().zip(&mut self.answers) {
            cycle.update(state, decision, 30, command, status);
        }
        let [one, other] = &self.answers;
        let tick = state.header.tick;
        assert!(one.0.as_bytes() == other.0.as_bytes(), "command of {tick}");
        assert!(one.1.as_bytes() == other.1.as_bytes(), "status of {tick}");
    }
}

/// Runs `demo`; the controllers are replaced every `every` ticks, and get no decision during
/// `silence`. Returns the stop actions that were seen.
fn run(demo: &str, policy: &str, script: &str, every: u64, silence: [u64; 2]) -> Vec<u32> {
    let mut spec = eval::template(demo, policy);
    spec.seed = 3;
    spec.script = cell_model::cells::script::parse(script, "script").expect("a script");
    spec.time_limit_s = Some(14.0);
    let cell = spec
        .load_cell_from(&cell_model::Data::checkout())
        .expect("a cell");
    let mut pairs: Vec<Pair> = (0..cell.arms.len())
        .map(|arm| Pair::new(&cell, arm))
        .collect();
    let mut sim =
        OneProcess::new(&demos::policies(), &spec, cell.clone()).expect("a cell that runs");
    let mut heard: Option<Decision> = None;
    let mut actions = Vec::new();
    loop {
        let tick = sim.state().header.tick;
        for pair in &mut pairs {
            if tick.is_multiple_of(every) {
                pair.renew(&cell);
            }
            pair.update(sim.state(), heard.as_ref());
            actions.push(pair.answers[0].1.stop_action);
        }
        let silent = (silence[0]..silence[1]).contains(&tick);
        if tick.is_multiple_of(DECISION_TICKS) && !silent {
            heard = Some(*sim.decision());
        }
        if !sim.tick().expect("a tick") {
            actions.dedup();
            return actions;
        }
    }
}

const RESET: &str = r#"{"at_s": 6.0, "do": "reset"}
{"at_s": 4.0, "do": "drag", "object": "red_cube", "to": [0.4, 0.35, 0.025]}"#;

#[test]
fn in_a_stack_with_a_reset_of_the_scene_and_a_task_that_falls_silent() {
    let actions = run("franka-stack", "fsm", RESET, 37, [2_000, 2_700]);
    assert!(
        actions.iter().any(|action| *action >= 3),
        "it held: {actions:?}"
    );
    run("franka-stack", "fsm", RESET, 1, [7_500, 8_000]);
}

#[test]
fn with_two_arms_around_one_stack() {
    let kill = r#"{"at_s": 5.0, "do": "kill", "process": "controller-1"}"#;
    run("franka-pyramid", "json", kill, 41, [6_000, 6_400]);
}
