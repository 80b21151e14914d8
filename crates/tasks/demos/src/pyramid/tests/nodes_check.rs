//! Rows N24 to N28: the checks, and the counts.

use behavior::{Status, Value};
use serde_json::json;

use super::{Bench, LEFT, WORK, bench, current, numbers, pose, set_of, stack, target, to_numbers};
use crate::pyramid::notes::TARGETS;

/// A cube that was put onto a stack of `below`.
fn put_down(below: &[u32], required: i64) -> Bench {
    let node = json!({"type": "MarkCubePlaced", "ports": {"required_count": required}});
    let mut bench = bench(LEFT, node);
    let layer = 0.025 + 0.05 * below.len() as f64;
    bench.works_at(WORK, 5);
    let goal = to_numbers(&pose(0.46, -0.28, layer));
    bench.set_local("object_goal", numbers(&goal));
    *bench.object(5) = [0.46, -0.28, layer];
    stack(&mut bench, ("left", -0.28), below);
    bench.set("recovery_requested:left", Value::Bool(true));
    bench
}

#[test]
fn n25_the_last_cube_completes_the_stack_and_counts_once() {
    let mut bench = put_down(&[0], 2);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.get("placed:left"), Some(set_of(&[0, 5])));
    assert_eq!(bench.get("stack_complete:left"), Some(Value::Bool(true)));
    assert_eq!(bench.text("cube_state:cube_6"), "placed:left");
    assert!(current(&bench).is_empty() && !bench.recovery());
    // The same again, as after a restart between the two.
    bench.works_at(WORK, 5);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.get("placed:left"), Some(set_of(&[0, 5])));
}

#[test]
fn n26_a_stack_that_is_not_complete_says_so() {
    let mut bench = put_down(&[0], 3);
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.get("stack_complete:left"), Some(Value::Bool(false)));
}

#[test]
fn a_cube_that_does_not_stand_there_is_not_counted() {
    let mut bench = put_down(&[], 3);
    bench.object(5)[0] += 0.05;
    assert_eq!(bench.tick(), Status::Failure);
    assert_eq!(bench.get("placed:left"), Some(set_of(&[])));
    let mut held = put_down(&[], 3);
    held.state.arms[LEFT].tcp.position = *held.object(5);
    held.hold(5);
    assert_eq!(held.tick(), Status::Failure);
}

#[test]
fn a_complete_stack_that_lost_a_cube_is_not_complete() {
    let mut bench = bench(LEFT, json!({"type": "CheckStackComplete"}));
    stack(&mut bench, ("left", -0.28), &[0, 1, 2]);
    assert_eq!(bench.tick(), Status::Success);
    *bench.object(1) = [0.3, -0.5, 0.025];
    assert_eq!(bench.tick(), Status::Failure);
    // A cube above the gap is not part of it either.
    assert_eq!(bench.get("placed:left"), Some(set_of(&[0])));
    assert_eq!(bench.text("cube_state:cube_3"), "available");
}

#[test]
fn leaving_the_centre_says_that_the_cube_is_carried() {
    let mut bench = bench(LEFT, json!({"type": "ReleaseCenter"}));
    bench.works_at(WORK, 2);
    bench.hold(2);
    bench.set_text("center_owner", "left");
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.text("center_owner"), "");
    assert_eq!(bench.text("cube_state:cube_3"), "carried:left");
    bench.set_text("center_owner", "right");
    assert_eq!(bench.tick(), Status::Success);
    assert_eq!(bench.text("center_owner"), "right", "not its own to give");
}

#[test]
fn the_place_is_shifted_and_turned_by_how_the_cube_lies_in_the_hand() {
    let mut bench = bench(LEFT, json!({"type": "CalibratePlaceTargets"}));
    bench.works_at(WORK, 0);
    for target in TARGETS {
        bench.set_local(target, numbers(&to_numbers(&pose(0.46, 0.0, 0.3))));
    }
    // Straight down, turned by 90 degrees, as the arm's own turn is.
    let half = std::f64::consts::FRAC_PI_4;
    let turned = [0.0, half.cos(), half.sin(), 0.0];
    bench.state.arms[LEFT].tcp.orientation_wxyz = turned;
    bench.hold(0);
    let tcp = bench.state.arms[LEFT].tcp.position;
    *bench.object(0) = [tcp[0] + 0.004, tcp[1] - 0.003, tcp[2] + 0.002];
    assert_eq!(bench.tick(), Status::Success);
    let [x, y, z, ..] = target(&bench, "place").unwrap();
    let expected = [0.46 - 0.004, -0.28 + 0.003, 0.025 - 0.002];
    for (found, expected) in [x, y, z].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    }
    bench.state.arms[LEFT].gripper.held_object = 0;
    assert_eq!(bench.tick(), Status::Running);
    assert!(bench.recovery(), "there is nothing to be placed");
}
