//! Suction is never lost by a restart or by silence.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test fails by panicking"
)]

use crate::support;

use ipc_types::GripperGoal;
use support::{Bench, down};

const AHEAD: [f64; 3] = [0.0, 0.75, 0.42];

#[test]
fn suction_follows_the_goal_and_there_are_no_fingers() {
    let mut bench = Bench::new();
    bench.goal(AHEAD, down(0.0));
    bench.run(20);
    assert_eq!(bench.command.gripper.suction, 0, "off until asked for");
    bench.gripper(GripperGoal::Close);
    bench.run(20);
    assert_eq!(bench.command.gripper.suction, 1);
    bench.gripper(GripperGoal::Keep);
    bench.run(20);
    assert_eq!(bench.command.gripper.suction, 1, "kept");
    let gripper = bench.status.gripper;
    assert_eq!(
        (gripper.width, gripper.force, gripper.suction),
        (0.0, 0.0, 1)
    );
    assert_eq!(bench.status.gripper_error, 0.0);
    bench.gripper(GripperGoal::Open);
    bench.run(20);
    assert_eq!(bench.command.gripper.suction, 0);
}

#[test]
fn a_task_that_falls_silent_lets_nothing_go() {
    let mut bench = Bench::new();
    bench.goal(AHEAD, down(0.0));
    bench.gripper(GripperGoal::Close);
    bench.run(300);
    for _ in 0..3000 {
        bench.tick(false);
        assert_eq!(bench.command.gripper.suction, 1);
    }
    assert_ne!(bench.status.stop_action, 0, "the arm holds");
}

#[test]
fn a_controller_that_begins_with_something_attached_keeps_it() {
    let mut bench = Bench::new();
    bench.attach(0, &nalgebra::Isometry3::identity());
    bench.goal(AHEAD, down(0.0));
    bench.gripper(GripperGoal::Keep);
    bench.tick(false);
    assert_eq!(bench.command.gripper.suction, 1, "before any decision");
    bench.run(50);
    assert_eq!(
        bench.command.gripper.suction, 1,
        "and with one that says keep"
    );
    // Lost meanwhile: what was asked for still holds.
    bench.detach();
    bench.run(50);
    assert_eq!(bench.command.gripper.suction, 1);
}

#[test]
fn a_controller_that_begins_with_nothing_sucks_nothing() {
    let mut bench = Bench::new();
    bench.run(50);
    assert_eq!(bench.command.gripper.suction, 0);
}
