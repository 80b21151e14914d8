//! A reset of the scene: nothing of the run before it moves the arm.

use cell_model::cells::script;
use cell_sim::{OneProcess, eval::template};

const RESET: usize = 4_500;
/// The first decision about the new scene.
const DECIDED: usize = 4_510;

/// Setpoints of the joints, by tick.
fn setpoints(lines: &str, ticks: usize) -> Vec<[f64; 7]> {
    let mut spec = template("franka-stack", "fsm");
    spec.seed = 1;
    spec.script = script::parse(lines, "script").unwrap();
    let cell = spec.load_cell_from(&cell_model::Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
    let mut all = Vec::new();
    while all.len() <= ticks {
        let joints = sim.state().arms()[0].setpoint_positions;
        all.push(std::array::from_fn(|joint| joints[joint]));
        assert!(sim.tick().unwrap());
    }
    all
}

fn off(one: &[f64; 7], other: &[f64; 7]) -> f64 {
    let off = one.iter().zip(other).map(|(a, b)| (a - b).abs());
    off.fold(0.0, f64::max)
}

#[test]
fn the_arm_rests_until_the_first_decision_about_the_new_scene_and_then_moves_as_at_a_fresh_start() {
    let ticks = 1_000;
    let fresh = setpoints("", ticks);
    let reset = setpoints(r#"{"at_s": 4.5, "do": "reset"}"#, DECIDED + ticks);
    let ticks_between = reset.iter().enumerate().take(DECIDED + 1);
    for (tick, joints) in ticks_between.skip(RESET + 1) {
        let moved = off(joints, &fresh[0]);
        assert!(
            moved < 1.0e-6,
            "tick {tick}: {moved} rad by an old decision"
        );
    }
    for tick in 0..=ticks {
        let differs = off(&reset[DECIDED + tick], &fresh[tick]);
        assert!(
            differs < 1.0e-4,
            "{tick} ticks after the decision: {differs} rad"
        );
    }
    assert!(off(&fresh[ticks], &fresh[0]) > 0.1, "it moves");
}
