//! A task that is dropped and made again from its record at every decision of a
//! whole job does not change one bit of what happens.

use cell_model::runs::spec::RunSpec;
use cell_sim::{OneProcess, eval};
use ipc_types::DECISION_TICKS;
use ipc_types::decision::Outcome;

/// Hash of the last state; with `restart`, the task never lives longer than
/// one decision.
fn hash(spec: &RunSpec, restart: bool) -> (u64, u64) {
    let cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&demos::policies(), spec, cell).unwrap();
    while sim.tick().unwrap() {
        let tick = sim.state().header.tick;
        if restart && tick.is_multiple_of(DECISION_TICKS) {
            sim.restart_task().unwrap();
        }
    }
    assert_eq!(sim.decision().outcome, Outcome::Done.code());
    (sim.state().header.tick, sim.state().state_hash)
}

fn assert_unnoticed(demo: &str, policy: &str, script: &str) {
    let mut spec = eval::template(demo, policy);
    spec.seed = 4;
    spec.script = cell_model::cells::script::parse(script, "script").unwrap();
    spec.time_limit_s = Some(300.0);
    assert_eq!(hash(&spec, false), hash(&spec, true), "{demo} {policy}");
}

/// A cube is pulled off the pyramid.
const PULLS: &str = r#"
{"at_s": 4.0, "do": "drag", "object": "cube_1", "to": [0.35, 0.0, 0.025]}
"#;

const DRAG: &str = r#"{"at_phase": "TRANSPORT", "nth": 2, "after_s": 0.3, "do": "drag", "object": "red_cube", "to": [0.40, 0.35, 0.025]}"#;

#[test]
fn of_a_stacking_machine_while_a_cube_is_dragged_away() {
    assert_unnoticed("franka-stack", "fsm", DRAG);
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_other_stacking_policies_while_a_cube_is_dragged_away() {
    for policy in ["ifelse", "bt"] {
        assert_unnoticed("franka-stack", policy, DRAG);
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_every_stacking_policy_undisturbed() {
    for policy in ["fsm", "ifelse", "bt"] {
        assert_unnoticed("franka-stack", policy, "");
    }
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_two_trees_of_the_pyramid_disturbed_and_not() {
    for script in ["", PULLS] {
        assert_unnoticed("franka-pyramid", "json", script);
    }
}
