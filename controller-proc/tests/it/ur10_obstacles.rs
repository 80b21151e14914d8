//! Objects as obstacles, with and without an object on the tool.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "a test fails by panicking"
)]

use crate::support;

use ipc_types::GripperGoal;
use nalgebra::{Isometry3, Vector3};
use support::{Bench, down};

/// Where the wall of a bin is in the way.
const TARGET: [f64; 3] = [0.2, 0.75, 0.2];
/// The middle of that bin.
const MIDDLE: [f64; 3] = [0.3475, 0.75, 0.2];

/// The distance from the target an arm ends with, a wall of bin 3 on the target, after
/// `change`, and the least clearance on the way.
fn ends(change: impl Fn(&mut Bench)) -> (f64, f64) {
    let mut bench = Bench::new();
    bench.put(3, MIDDLE);
    bench.decision.goals[0].object_mask = 1 << 3;
    bench.goal(TARGET, down(0.0));
    change(&mut bench);
    let mut least = f64::INFINITY;
    for _ in 0..5000 {
        bench.tick(true);
        least = bench.status.min_clearance.min(least);
    }
    assert_eq!(bench.violations, 0);
    (bench.error(), least)
}

#[test]
fn an_object_counts_while_it_is_there_and_its_bit_is_set() {
    let (error, clearance) = ends(|_| ());
    assert!(error > 0.02, "the bin is in the way: {error}");
    assert!(clearance > 0.0, "{clearance}");
    let (error, _) = ends(|bench| bench.decision.goals[0].object_mask = 1 << 4);
    assert!(error < 0.005, "another bit: {error}");
    let (error, _) = ends(|bench| bench.state.objects[3].flags = 0);
    assert!(error < 0.005, "not there: {error}");
}

#[test]
fn an_object_that_moves_is_kept_away_from_where_it_is() {
    let mut bench = Bench::new();
    bench.decision.goals[0].object_mask = 1;
    bench.goal(TARGET, down(0.0));
    bench.run(5000);
    assert!(bench.error() < 0.005);
    // A bin comes along at 0.05 m/s and stops with the target inside.
    for tick in 0..8000 {
        let y = 0.3 + 5.0e-5 * f64::from(tick);
        bench.put(0, [TARGET[0], y, TARGET[2]]);
        bench.tick(true);
        assert!(bench.status.min_clearance > 0.0, "tick {tick}");
    }
    assert!(bench.error() > 0.05, "the arm gave way");
    assert_eq!(bench.violations, 0);
}

#[test]
fn what_is_held_is_no_obstacle_to_its_own_arm() {
    let hanging = Isometry3::translation(0.0735, 0.0, 0.0);
    let (error, _) = ends(|bench| bench.attach(3, &hanging));
    assert!(error < 0.005, "{error}");
}

/// Clearance and error over a bin below the target, with or without a bin on the tool.
fn over_another(held: bool) -> (f64, f64) {
    let mut bench = Bench::new();
    bench.decision.goals[0].object_mask = 1 << 1;
    // The top of bin 1 is 0.05 m below the tip, and a held bin would reach into it.
    bench.put(1, [TARGET[0], TARGET[1], TARGET[2] - 0.05 - 0.0735]);
    bench.goal(TARGET, down(0.0));
    if held {
        let hanging =
            Isometry3::from_parts(Vector3::new(0.0735, 0.0, 0.0).into(), down(0.0).inverse());
        bench.attach(0, &hanging);
    }
    bench.run(5000);
    assert_eq!(bench.violations, 0);
    (bench.error(), bench.status.min_clearance)
}

#[test]
fn what_is_held_keeps_away_from_obstacles_as_the_arm_does() {
    let (error, _) = over_another(false);
    assert!(error < 0.02, "{error}");
    let (error, clearance) = over_another(true);
    assert!(error > 0.08, "the held bin stays above: {error}");
    assert!(clearance > 0.0, "{clearance}");
}

#[test]
fn a_restored_cycle_goes_on_with_what_is_held_bit_for_bit() {
    let mut bench = Bench::new();
    bench.decision.goals[0].object_mask = u64::MAX;
    bench.decision.goals[0].obstacle_mask = u64::MAX;
    bench.put(5, [0.3, 0.7, 0.0]);
    bench.goal([0.6, 0.3, 0.3], down(0.4));
    bench.gripper(GripperGoal::Close);
    bench.run(200);
    bench.attach(2, &Isometry3::translation(0.1, 0.0, 0.01));
    bench.run(200);
    let mut bytes = vec![0; ipc_types::tap::KEYFRAME_BYTES];
    let length = bench.cycle.save(30, &mut bytes).unwrap();
    let mut other = controller_proc::cycle::Cycle::new(&bench.cell, 0).unwrap();
    assert_eq!(other.restore(&bytes[..length]), Ok(30));
    let mut again = Bench {
        cycle: other,
        state: bench.state.clone(),
        decision: bench.decision.clone(),
        cell: bench.cell.clone(),
        ..Bench::new()
    };
    (again.command, again.status) = (bench.command, bench.status);
    for _ in 0..500 {
        bench.tick(true);
        again.tick(true);
        assert_eq!(bench.command.joint_positions, again.command.joint_positions);
        assert_eq!(
            bench.status.min_clearance.to_bits(),
            again.status.min_clearance.to_bits()
        );
    }
    assert_eq!(bench.command.gripper.suction, 1);
}
