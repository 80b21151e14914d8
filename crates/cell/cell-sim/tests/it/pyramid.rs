//! Two arms take the pyramid apart, undisturbed and disturbed: all six cubes
//! end up in two stacks, and no hand opens around a cube that hangs in the air.

use cell_sim::{OneProcess, eval::template};
use ipc_types::GripperGoal;
use ipc_types::decision::Outcome;

const ALL: [u32; 6] = [0, 1, 2, 3, 4, 5];

struct Run {
    sim: OneProcess,
    lines: Vec<String>,
}

impl Run {
    fn new(seed: u64, script: &str) -> Self {
        let mut spec = template("franka-pyramid", "json");
        spec.seed = seed;
        spec.time_limit_s = Some(200.0);
        spec.script = cell_model::cells::script::parse(script, "script").expect("a script");
        let cell = spec
            .load_cell_from(&cell_model::Data::checkout())
            .expect("the built-in cell");
        let sim = OneProcess::new(&demos::policies(), &spec, cell).expect("a cell that runs");
        Self {
            sim,
            lines: Vec::new(),
        }
    }

    /// To the end, which has to be two stacks.
    #[track_caller]
    fn finish(mut self) -> Self {
        while self.sim.tick().expect("a tick") {
            self.check_hands();
            let trace = self.sim.take_trace().into_iter();
            self.lines.extend(trace.map(|(_, line)| line));
        }
        let decision = self.sim.decision();
        let placed = &decision.placed[..decision.placed_count as usize];
        let outcome = Outcome::from_code(decision.outcome);
        assert_eq!(outcome, Some(Outcome::Done), "{:#?}", self.lines);
        assert_eq!(placed, ALL, "{:#?}", self.lines);
        self
    }

    /// A hand that holds a cube is commanded to open only where the cube is supported: in a
    /// layer of the stack, or on the table where it is put out of the way.
    fn check_hands(&self) {
        let state = self.sim.state();
        let decision = self.sim.decision();
        for (arm, goal) in decision.goals.iter().take(2).enumerate() {
            let held = state.arms()[arm].gripper.held_object;
            if held == 0 || goal.gripper != GripperGoal::Open.code() {
                continue;
            }
            let [x, y, z] = state.objects()[held as usize - 1].pose.position;
            let layer = (z - 0.025) / 0.05;
            let in_place = (layer - layer.round()).abs() < 0.2;
            assert!(
                in_place,
                "arm {arm} lets go of cube {held} at {x} {y} {z}: {:#?}",
                self.lines
            );
        }
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }
}

#[test]
fn undisturbed_no_cube_is_lost_and_none_picked_up_twice() {
    for seed in [1, 19] {
        let run = Run::new(seed, "").finish();
        let decision = run.sim.decision();
        assert_eq!(
            (decision.drops, decision.recoveries, run.count("[acquire]")),
            (0, 0, 6),
            "seed {seed}: {:#?}",
            run.lines
        );
        let violations: u64 = run
            .sim
            .state()
            .arms()
            .iter()
            .map(|a| a.limit_violations)
            .sum();
        assert_eq!(violations, 0);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_cube_pulled_from_the_hand_of_either_arm_is_fetched_again() {
    for (phase, cube, to) in [
        ("LEFT_CARRY", "cube_1", "[0.35, -0.55, 0.025]"),
        ("RIGHT_CARRY", "cube_3", "[0.35, 0.55, 0.025]"),
        ("RIGHT_LOWER", "cube_3", "[0.3, 0.5, 0.025]"),
    ] {
        let script = format!(
            r#"{{"at_phase": "{phase}", "after_s": 0.2, "do": "drag", "object": "{cube}", "to": {to}}}"#
        );
        let run = Run::new(2, &script).finish();
        assert_eq!(run.sim.decision().drops, 1, "{phase}: {:#?}", run.lines);
        assert_eq!(run.count("was lost"), 1);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_cube_out_of_reach_is_waited_for_until_it_comes_back() {
    let script = r#"{"at_phase": "LEFT_APPROACH", "do": "drag", "object": "cube_1", "to": [0.95, 0.3, 0.2], "for_s": 4}
{"at_s": 20.0, "do": "drag", "object": "cube_1", "to": [0.4, -0.1, 0.1], "for_s": 6}"#;
    let run = Run::new(1, script).finish();
    assert_eq!(
        run.count("cube_1 is out of reach, and available again"),
        1,
        "{:#?}",
        run.lines
    );
}

#[test]
fn a_cube_that_one_arm_lacks_and_only_the_other_reaches_is_handed_over() {
    let script = r#"{"at_s": 20.0, "do": "drag", "object": "cube_1", "to": [0.57, 0.0, 0.025], "for_s": 1.5}"#;
    let run = Run::new(0, script).finish();
    assert!(
        run.count("out of the way") > 0 && run.count("there is work again") > 0,
        "{:#?}",
        run.lines
    );
}

#[test]
#[ignore = "slow: .ci/long"]
fn cubes_that_change_sides_are_taken_by_the_arm_that_reaches_them() {
    let script = r#"{"at_s": 3.0, "do": "drag", "object": "cube_2", "to": [0.46, 0.12, 0.30], "for_s": 1.0}
{"at_s": 4.0, "do": "drag", "object": "cube_2", "to": [0.36, 0.25, 0.03], "for_s": 2.0}
{"at_s": 3.0, "do": "drag", "object": "cube_3", "to": [0.40, -0.12, 0.20], "for_s": 1.0}
{"at_s": 4.0, "do": "drag", "object": "cube_3", "to": [0.36, -0.25, 0.03], "for_s": 2.0}"#;
    Run::new(0, script).finish();
}

#[test]
fn a_stack_that_loses_its_lowest_cube_is_built_again() {
    let script = r#"{"at_phase": "LEFT_CARRY", "nth": 3, "do": "drag", "object": "cube_1", "to": [0.3, -0.5, 0.025]}"#;
    let run = Run::new(1, script).finish();
    assert!(run.count("[stack] left: cube_1 left the stack") > 0);
}

#[test]
fn a_finished_stack_that_is_disturbed_while_the_other_arm_works_is_built_again() {
    // The arm that is done first, and the last layer of its stack: by the time.
    let line = |cube: &str, to: &str, at_s: f64| {
        format!(r#"{{"at_s": {at_s}, "do": "drag", "object": "{cube}", "to": {to}, "for_s": 1.5}}"#)
    };
    let undisturbed = Run::new(1, "").finish();
    let done: Vec<_> = undisturbed
        .lines
        .iter()
        .filter(|l| l.contains("[done]"))
        .collect();
    let first = if done[0].contains("left") {
        "left"
    } else {
        "right"
    };
    let top = |l: &&String| l.contains(&format!("[placed] {first}:")) && l.contains("number 3");
    let placed = undisturbed.lines.iter().find(top).unwrap();
    let cube = placed.split_whitespace().nth(2).unwrap();
    let away = if first == "left" {
        "[0.35, -0.55, 0.1]"
    } else {
        "[0.35, 0.55, 0.1]"
    };
    let ticks = undisturbed.sim.state().header.tick as f64;
    // Just before the other arm is done.
    let run = Run::new(1, &line(cube, away, ticks * 1.0e-3 - 2.0)).finish();
    assert_eq!(run.count("there is work again"), 1, "{:#?}", run.lines);
}

#[test]
fn a_fallen_pyramid_is_sorted_out() {
    let script =
        r#"{"at_s": 0.1, "do": "drag", "object": "cube_5", "to": [0.46, -0.2, 0.1], "for_s": 3}"#;
    Run::new(1, script).finish();
}

#[test]
fn controllers_that_are_started_again_drop_nothing() {
    let script = r#"{"at_phase": "LEFT_CARRY", "nth": 2, "do": "kill", "process": "controller-0"}
{"at_phase": "RIGHT_LIFT", "nth": 2, "do": "kill", "process": "controller-1"}"#;
    let run = Run::new(1, script).finish();
    assert_eq!(run.sim.decision().drops, 0, "{:#?}", run.lines);
}
