//! The links of an arm as bodies of the engine.

use cell_model::{Link, Robot};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::shapes;
use crate::engine::tag::Tag;

/// Friction of links that are not pads.
// Only pads are meant to hold by friction; they have the friction of the gripper.
const LINK_FRICTION: f64 = 0.5;

/// Friction coefficient of a link.
pub(super) fn friction_of(robot: &Robot, link: usize) -> f64 {
    let finger = |gripper: &cell_model::ParallelGripper| {
        gripper.finger_joints.iter().any(|joint| joint + 1 == link)
    };
    match &robot.gripper {
        Some(gripper) if finger(gripper) => gripper.pad_friction,
        _ => LINK_FRICTION,
    }
}

/// Puts the body and the shapes of a link into the engine.
pub(super) fn insert_link(
    world: &mut PhysicsWorld,
    tag: Tag,
    link: &Link,
    pose: &Isometry3<f64>,
    friction: f64,
) -> RigidBodyHandle {
    let base = matches!(tag, Tag::Link { link: 0, .. });
    let builder = if base {
        RigidBodyBuilder::fixed()
    } else {
        RigidBodyBuilder::dynamic()
    };
    let mut builder = builder
        .pose(convert::to_pose(pose))
        // Links never sleep, and have no gravity: it acts as joint efforts (ADR 0006).
        .can_sleep(false)
        .gravity_scale(0.0);
    if !base {
        let center = convert::to_vector(&link.center_of_mass);
        builder = builder.additional_mass_properties(MassProperties::with_inertia_matrix(
            center,
            link.mass,
            convert::to_matrix(&link.inertia),
        ));
    }
    let body = world.bodies.insert(builder.build());
    // No density: the mass of a link is that of its URDF, not of its collision shapes.
    for part in &link.shapes {
        let (shape, own) = shapes::shared(&part.shape);
        let collider = ColliderBuilder::new(shape)
            .position(convert::to_pose(&(part.pose * own)))
            .density(0.0)
            .friction(friction)
            .user_data(tag.encode());
        world
            .colliders
            .insert_with_parent(collider.build(), body, &mut world.bodies);
    }
    body
}
