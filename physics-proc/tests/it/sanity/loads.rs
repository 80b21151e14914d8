//! Loads between fingers do not slip, up to the friction of the pads.

use cell_model::{Cell, Data, Robot, Shape};
use nalgebra::{Isometry3, Vector3};

use crate::support::Rig;

/// Force of each finger (N).
const FORCE_N: f64 = 20.0;
/// Largest way of a held load in the hand (m).
const SLIP_M: f64 = 0.01e-3;
/// Share by which the measured force may differ from the one that is set.
const FORCE_RIGHT: f64 = 0.05;

/// A robot whose hand is around a box of `mass` in the middle of the table.
fn holding(robot: &str, mass: f64, friction: f64, size_m: [f64; 3]) -> Rig {
    let pose = Isometry3::translation(0.5, 0.0, 0.5 * size_m[2]);
    holding_shape(robot, mass, friction, Shape::Box { size_m }, pose)
}

fn holding_shape(robot: &str, mass: f64, friction: f64, shape: Shape, pose: Isometry3<f64>) -> Rig {
    let data = Data::checkout();
    let mut cell = Cell::load(&data, "cube", 1, None).unwrap();
    cell.arms[0].robot = Robot::load(&data, robot).unwrap();
    let object = &mut cell.objects[0];
    object.shape = shape;
    (object.mass, object.friction) = (mass, friction);
    object.pose = pose;
    let mut rig = Rig::with(cell);
    rig.force = FORCE_N;
    rig.pick_at(pose.translation.vector.into(), 0.3);
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

/// Round things that the pads touch along a line neither slip nor swing about it.
#[test]
fn round_things_are_held_still() {
    let lying = |radius: f64| {
        let along_x = super::scene::about(Vector3::y_axis(), 90.0);
        Isometry3::translation(0.5, 0.0, radius + 0.0001) * along_x
    };
    let cylinder = |radius_m: f64, height_m: f64| Shape::Cylinder { radius_m, height_m };
    let things = [
        (
            "a can",
            0.015,
            cylinder(0.033, 0.115),
            Isometry3::translation(0.5, 0.0, 0.0575),
        ),
        ("a rod", 0.045, cylinder(0.01, 0.06), lying(0.01)),
        (
            "a capsule",
            0.045,
            Shape::Capsule {
                radius_m: 0.01,
                height_m: 0.04,
            },
            lying(0.01),
        ),
    ];
    for (name, mass, shape, pose) in things {
        let mut rig = holding_shape("panda", mass, 0.6, shape, pose);
        rig.stay(500);
        let start = rig.object_in_hand(0);
        let (mut way, mut turn) = (0.0_f64, 0.0_f64);
        for _ in 0..150 {
            rig.stay(100);
            let now = rig.object_in_hand(0);
            way = way.max((now.translation.vector - start.translation.vector).norm());
            turn = turn.max(now.rotation.angle_to(&start.rotation).to_degrees());
        }
        assert!(
            way < 0.1e-3 && turn < 0.5,
            "{name}: {way} m, {turn} degrees"
        );
    }
}
