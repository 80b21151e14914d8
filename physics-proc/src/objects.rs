//! Fixtures and movable objects in the engine.

use cell_model::{Cell, Shape};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::*;

use crate::tag::Tag;
use crate::{convert, shapes};

/// What stands still, in the engine.
pub(crate) struct Fixtures {
    /// By fixture of the cell: its collider, where it is solid.
    pub(crate) colliders: Vec<Option<ColliderHandle>>,
}

/// One fixed body with everything that stands still.
pub(crate) fn insert_fixtures(world: &mut PhysicsWorld, cell: &Cell) -> Fixtures {
    let ground = world.bodies.insert(RigidBodyBuilder::fixed().build());
    let colliders = cell.fixtures.iter().map(|fixture| {
        let collider = collider(
            &fixture.shape,
            &fixture.pose,
            fixture.friction,
            Tag::Fixture,
        );
        fixture.solid.then(|| {
            world
                .colliders
                .insert_with_parent(collider.build(), ground, &mut world.bodies)
        })
    });
    Fixtures {
        colliders: colliders.collect(),
    }
}

/// Every object, in the order of the cell. Those that have not come yet are
/// disabled; only those sleep that may.
pub(crate) fn insert(world: &mut PhysicsWorld, cell: &Cell) -> Vec<RigidBodyHandle> {
    let objects = cell.objects.iter().enumerate().map(|(index, object)| {
        let builder = RigidBodyBuilder::dynamic()
            .pose(convert::to_pose(&object.pose))
            .can_sleep(object.sleeps)
            .angular_damping(object.angular_damping)
            .enabled(!object.parked)
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
