//! Fixtures and movable objects in the engine.

use cell_model::{Cell, Shape};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::*;

use crate::tag::Tag;
use crate::{convert, shapes};

/// One fixed body with everything that stands still.
pub(crate) fn insert_fixtures(world: &mut PhysicsWorld, cell: &Cell) {
    let ground = world.bodies.insert(RigidBodyBuilder::fixed().build());
    for fixture in cell.fixtures.iter().filter(|fixture| fixture.solid) {
        let collider = collider(
            &fixture.shape,
            &fixture.pose,
            fixture.friction,
            Tag::Fixture,
        );
        world
            .colliders
            .insert_with_parent(collider.build(), ground, &mut world.bodies);
    }
}

/// Every object, in the order of the cell. They never sleep: there are few, and
/// a policy may look at any of them.
pub(crate) fn insert(world: &mut PhysicsWorld, cell: &Cell) -> Vec<RigidBodyHandle> {
    let objects = cell.objects.iter().enumerate().map(|(index, object)| {
        let builder = RigidBodyBuilder::dynamic()
            .pose(convert::to_pose(&object.pose))
            .can_sleep(false)
            .gyroscopic_forces_enabled(false);
        let body = world.bodies.insert(builder.build());
        let collider = collider(
            &object.shape,
            &Isometry3::identity(),
            object.friction,
            Tag::Object(index),
        )
        .mass(object.mass);
        world
            .colliders
            .insert_with_parent(collider.build(), body, &mut world.bodies);
        body
    });
    objects.collect()
}

fn collider(shape: &Shape, pose: &Isometry3<f64>, friction: f64, tag: Tag) -> ColliderBuilder {
    let (shape, own) = shapes::shared(shape);
    ColliderBuilder::new(shape)
        .position(convert::to_pose(&(pose * own)))
        .friction(friction)
        .restitution(0.0)
        .user_data(tag.encode())
}
