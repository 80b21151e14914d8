//! Limits of joints: the engine has them only where they are near.

use cell_model::{Cell, Data};
use rapier3d_f64::prelude::*;

use crate::arm::multibody::{Arm, DriveTarget};
use crate::world::World;

/// The joint that is driven, and its place in the engine's solution.
const JOINT: usize = 3;
const ANGLE: usize = JointAxis::AngX as usize;

fn world() -> World {
    let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
    World::new(&cell).unwrap()
}

fn link<'w>(engine: &'w mut PhysicsWorld, arm: &Arm) -> &'w mut MultibodyLink {
    let joints = &mut engine.multibody_joints;
    let place = *joints.rigid_body_link(arm.bodies[JOINT + 1]).unwrap();
    let multibody = joints.get_multibody_mut(place.multibody).unwrap();
    multibody.link_mut(place.id).unwrap()
}

/// Drives the joint for a tick and returns its position; `keeps` has the engine keep its
/// limit in any case.
fn driven(world: &mut World, target: &DriveTarget, keeps: bool) -> f64 {
    let (engine, arms) = world.engine_and_arms();
    let (engine, arm) = (engine.rapier_mut(), &arms.bodies[0]);
    arm.drive(engine, JOINT, target);
    if keeps {
        link(engine, arm).joint.data.limit_axes |= JointAxesMask::ANG_X;
    }
    engine.step();
    link(engine, arm).joint.coords()[ANGLE]
}

#[test]
fn a_joint_that_is_driven_into_its_limit_stops_there_as_with_a_limit_that_is_always_in_force() {
    let (mut near, mut always) = (world(), world());
    let spec = &near.engine_and_arms().1.bodies[0].robot.joints[JOINT];
    let (upper, effort) = (spec.upper, spec.effort);
    let target = DriveTarget {
        position: upper + 0.2,
        max_effort: effort,
        ..DriveTarget::default()
    };
    let (mut highest, mut last) = (f64::NEG_INFINITY, 0.0);
    for tick in 0..3000 {
        last = driven(&mut near, &target, false);
        assert_eq!(
            last.to_bits(),
            driven(&mut always, &target, true).to_bits(),
            "{tick}"
        );
        highest = highest.max(last);
    }
    assert!((last - upper).abs() < 1.0e-3, "{last} {upper}");
    assert!(highest < upper + 1.0e-2, "{highest} {upper}");
}

#[test]
fn a_limit_that_is_far_is_not_part_of_the_solution() {
    let mut world = world();
    let spec = &world.engine_and_arms().1.bodies[0].robot.joints[JOINT];
    let target = DriveTarget {
        position: spec.home,
        max_effort: spec.effort,
        ..DriveTarget::default()
    };
    driven(&mut world, &target, false);
    let (engine, arms) = world.engine_and_arms();
    let axes = link(engine.rapier_mut(), &arms.bodies[0])
        .joint
        .data
        .limit_axes;
    assert!(axes.is_empty(), "{axes:?}");
}
