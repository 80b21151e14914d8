//! Loads between fingers do not slip, up to the friction of the pads.

use cell_model::{Cell, Data, Robot, Shape};

use crate::support::Rig;

/// Force of each finger (N).
const FORCE_N: f64 = 20.0;
/// Largest way of a held load in the hand (m).
const SLIP_M: f64 = 0.01e-3;
/// Share by which the measured force may differ from the one that is set.
const FORCE_RIGHT: f64 = 0.05;

/// A robot whose hand is around a box of `mass` in the middle of the table.
fn holding(robot: &str, mass: f64, friction: f64, size_m: [f64; 3]) -> Rig {
    let data = Data::checkout();
    let mut cell = Cell::load(&data, "cube", 1, None).unwrap();
    cell.arms[0].robot = Robot::load(&data, robot).unwrap();
    let object = &mut cell.objects[0];
    object.shape = Shape::Box { size_m };
    (object.mass, object.friction) = (mass, friction);
    object.pose = nalgebra::Isometry3::translation(0.5, 0.0, 0.5 * size_m[2]);
    let mut rig = Rig::with(cell);
    rig.force = FORCE_N;
    rig.pick(0, 0.3);
    rig
}

/// Holds it at `place` for `seconds`.
fn check(robot: &str, mass: f64, place: [f64; 3], seconds: u64) {
    // The pads have 1.0, so 0.85 between them: 3.4 kg at 20 N.
    let mut rig = holding(robot, mass, 0.7, [0.05; 3]);
    let goal = rig.solve(place, 0.0);
    rig.travel(goal, 2.0);
    rig.stay(1_000);
    let start = rig.object_in_hand(0);
    let mut range = (f64::INFINITY, 0.0_f64);
    for _ in 0..seconds * 10 {
        rig.stay(100);
        let force = rig.state().arms[0].gripper.grip_force;
        range = (range.0.min(force), range.1.max(force));
    }
    let end = rig.object_in_hand(0);
    let slip = (end.translation.vector - start.translation.vector).norm();
    let said = format!("{robot}, {mass} kg at {place:?}, {seconds} s: {slip} m, {range:?} N");
    assert!(slip < SLIP_M, "{said}");
    let is_right = |force: f64| (force / FORCE_N - 1.0).abs() < FORCE_RIGHT;
    assert!(is_right(range.0) && is_right(range.1), "{said}");
}

#[test]
fn light_and_heavy_loads_are_held_without_creep() {
    check("panda", 0.05, [0.5, 0.0, 0.3], 2);
    check("panda", 2.0, [0.5, 0.0, 0.3], 4);
    check("fr3", 3.0, [0.45, -0.3, 0.3], 4);
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_load_is_held_for_a_minute_at_every_posture() {
    for robot in ["panda", "fr3"] {
        for place in [[0.45, 0.0, 0.3], [0.7, 0.0, 0.3], [0.35, -0.45, 0.5]] {
            for mass in [0.05, 0.5, 1.0, 1.6, 2.0, 2.5, 3.0] {
                check(robot, mass, place, 60);
            }
        }
    }
}

#[test]
fn thin_things_are_held_with_the_whole_force() {
    for width in [0.001, 0.004, 0.02, 0.07] {
        let mut rig = holding("panda", 0.02, 0.7, [0.03, width, 0.03]);
        rig.stay(500);
        let gripper = rig.state().arms[0].gripper;
        let said = format!("{width} m wide: {} N", gripper.grip_force);
        assert_eq!(gripper.held_object, 1, "{said}");
        assert!(
            (gripper.grip_force / FORCE_N - 1.0).abs() < FORCE_RIGHT,
            "{said}"
        );
    }
}
