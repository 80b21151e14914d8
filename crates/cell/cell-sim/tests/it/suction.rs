//! Jobs of a suction cup that a user writes: move, close, lift.

use std::fmt::Write as _;

use cell_model::Data;
use cell_sim::{OneProcess, eval::template};
use ipc_types::decision::Outcome;

/// A UR10 above a table with a box of this mass (kg).
fn cell(name: &str, mass_kg: f64) -> String {
    format!(
        r#"description = "A box on a table"
policies = ["json"]
default_policy = "json"
time_limit_s = 40.0
camera = {{ eye_m = [1.4, 0.6, 0.9], target_m = [0.5, 0.0, 0.1] }}

[[arm]]
name = "ur10"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]

[[object]]
name = "box"
shape = {{ kind = "box", size_m = [0.1, 0.1, 0.1] }}
mass_kg = {mass_kg:.1}
friction = 0.6
position_m = [0.1, 0.75, -0.35]
colour = [0.8, 0.2, 0.2]

[[fixture]]
name = "table"
shape = {{ kind = "box", size_m = [3.0, 3.0, 0.1] }}
position_m = [0.0, 0.0, -0.45]
friction = 0.6
obstacle = false
colour = [0.5, 0.5, 0.5]

[task]
kind = "tree"
behaviour = "{name}.tree.json"

[task.place.mark]
position_m = [-0.4, 0.7, -0.4]
"#
    )
}

struct Ended {
    outcome: Option<Outcome>,
    breaks: u32,
    /// Largest force on the cup (N).
    peak_n: f64,
    lines: String,
}

/// Runs a sequence of these nodes.
fn run(name: &str, mass_kg: f64, nodes: &str) -> Ended {
    let dir = std::env::temp_dir().join(format!("robocell-cup-{name}-{}", std::process::id()));
    std::fs::create_dir_all(dir.join("cells")).unwrap();
    let write = |file: &str, text: &str| std::fs::write(dir.join("cells").join(file), text);
    write(&format!("{name}.toml"), &cell(name, mass_kg)).unwrap();
    let tree = format!(
        r#"{{"format": "behavior-tree/1", "name": "{name}", "root": {{"id": "root",
            "type": "Sequence", "ports": {{"memory": true}}, "children": [{nodes}]}}}}"#
    );
    write(&format!("{name}.tree.json"), &tree).unwrap();
    let mut spec = template(name, "json");
    spec.time_limit_s = Some(40.0);
    spec.data_dir = Some(dir.clone());
    let cell = spec.load_cell_from(&Data::checkout()).unwrap();
    let mut sim = OneProcess::new(&demos::policies(), &spec, cell).unwrap();
    let mut lines = String::new();
    while sim.tick().unwrap() {
        for (tick, line) in sim.take_trace() {
            writeln!(lines, "{tick} {line}").unwrap();
        }
    }
    std::fs::remove_dir_all(&dir).unwrap();
    let gripper = &sim.state().arms()[0].gripper;
    Ended {
        outcome: Outcome::from_code(sim.decision().outcome),
        breaks: gripper.breaks,
        peak_n: gripper.peak_force,
        lines,
    }
}

/// Moves to this height above the box (m), closes and lifts.
fn grip(above_m: f64) -> String {
    format!(
        r#"{{"id": "to", "type": "MoveTo", "ports": {{"object": "box", "above_m": {above_m:?}}}}},
           {{"id": "close", "type": "Close", "ports": {{"object": "box"}}}},
           {{"id": "up", "type": "Up", "ports": {{"by_m": 0.1}}}}"#
    )
}

#[test]
fn a_cup_that_closes_after_a_motion_keeps_its_grip() {
    for millimetres in [0, 1, 2, 3] {
        let name = format!("gap{millimetres}");
        let ended = run(&name, 0.5, &grip(f64::from(millimetres) * 1.0e-3));
        let lines = &ended.lines;
        assert_eq!(ended.outcome, Some(Outcome::Done), "{name}: {lines}");
        assert_eq!(ended.breaks, 0, "{name}: {lines}");
        // 5 N of weight; the limit is 50 N.
        assert!(ended.peak_n < 25.0, "{name}: {} N", ended.peak_n);
    }
}

#[test]
fn a_load_of_four_fifths_of_the_limit_is_lifted_and_carried() {
    let nodes = r#"{"id": "pick", "type": "Pick", "ports": {"object": "box"}},
        {"id": "carry", "type": "MoveTo",
         "ports": {"object": "box", "place": "mark", "above_m": 0.1}}"#;
    let ended = run("heavy", 4.0, nodes);
    let (lines, peak_n) = (&ended.lines, ended.peak_n);
    assert_eq!(ended.outcome, Some(Outcome::Done), "{peak_n} N: {lines}");
    assert_eq!(ended.breaks, 0, "{peak_n} N: {lines}");
    assert!(!lines.contains("[retry]"), "{lines}");
}

#[test]
fn a_load_of_four_fifths_of_the_limit_is_set_down() {
    let nodes = r#"{"id": "pick", "type": "Pick", "ports": {"object": "box"}},
        {"id": "place", "type": "Place", "ports": {"object": "box", "place": "mark"}}"#;
    let ended = run("setdown", 4.0, nodes);
    let (lines, peak_n) = (&ended.lines, ended.peak_n);
    assert_eq!(ended.outcome, Some(Outcome::Done), "{peak_n} N: {lines}");
    assert_eq!(ended.breaks, 0, "{peak_n} N: {lines}");
}
