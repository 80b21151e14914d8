//! The path of a motion in a file to its target.

use std::sync::Arc;

use cell_model::{Cell, Data};
use ipc_types::ArmGoal;
use robocell_skills::{Setup, nodes};
use serde_json::{Value, json};

use crate::bench::Bench;

/// The first goal of a `MoveTo` with these ports, in a cell with guides.
fn goal(ports: &Value) -> (ArmGoal, Cell) {
    let cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
    let setup = Arc::new(Setup::new(&cell, []));
    let file = json!({
        "format": "behavior-tree/1", "name": "one",
        "root": { "id": "go", "type": "MoveTo", "ports": ports }
    });
    let library = nodes::library(&setup);
    let mut bench = Bench::of((&cell, setup), &library, 0, &file);
    // The first one leaves the object beside the tool, if there is one.
    bench.tick();
    (bench.goal(), cell)
}

#[test]
fn posture_corridor_and_obstacles_are_those_of_the_file() {
    let posture = [-1.5, -1.6, -1.5, -1.6, 1.5, 0.1];
    let pose = json!([0.6, -0.3, 0.4]);
    let (plain, cell) = goal(&json!({ "pose": pose }));
    let (asked, _) = goal(&json!({
        "pose": pose, "posture": posture, "approach": [0.0, 0.0, -0.2],
        "approach_width": 0.005, "ignore": "belt", "guide": "navigation_"
    }));
    let bit = |name: &str| 1_u64 << cell.obstacles().position(|o| o.name == name).unwrap();
    let counts = |goal: &ArmGoal, name| goal.obstacle_mask & bit(name) != 0;
    let all = ["housing", "belt", "navigation_dome", "flip_sphere"];
    assert_eq!(
        all.map(|name| counts(&plain, name)),
        [true, true, false, false]
    );
    assert_eq!(
        all.map(|name| counts(&asked, name)),
        [true, false, true, false]
    );
    assert_eq!((plain.has_posture, asked.has_posture), (0, 1));
    assert_eq!(asked.posture[..6], posture);
    assert_eq!(
        (asked.approach, asked.approach_std_dev),
        ([0.0, 0.0, -0.2], 0.005)
    );
    assert_eq!((plain.approach, plain.approach_std_dev), ([0.0; 3], 0.0));
}
