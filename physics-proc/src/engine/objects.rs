//! Fixtures and movable objects in the engine.

use cell_model::{Cell, ObjectSpec, Shape};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::settings::LENGTH_UNIT_M;
use crate::engine::shapes;
use crate::engine::tag::Tag;

/// Fixtures in the engine.
pub(crate) struct Fixtures {
    /// By fixture of the cell: its collider, if it is solid.
    pub(crate) colliders: Vec<Option<ColliderHandle>>,
}

/// Inserts one fixed body with all fixtures as its colliders.
pub(crate) fn insert_fixtures(world: &mut PhysicsWorld, cell: &Cell) -> Fixtures {
    let ground = world.bodies.insert(RigidBodyBuilder::fixed().build());
    let fixtures = cell.fixtures.iter().enumerate();
    let colliders = fixtures.map(|(index, fixture)| {
        let collider = collider(
            &fixture.shape,
            &fixture.pose,
            fixture.friction,
            Tag::Fixture(index),
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

/// The movable objects, by their index in the cell file.
pub(crate) struct Objects {
    bodies: Vec<RigidBodyHandle>,
    specs: Vec<ObjectSpec>,
}

impl Objects {
    /// Inserts them.
    pub(crate) fn insert(engine: &mut PhysicsWorld, cell: &Cell) -> Self {
        Self {
            bodies: insert(engine, cell),
            specs: cell.objects.clone(),
        }
    }

    /// Their bodies.
    pub(crate) fn bodies(&self) -> &[RigidBodyHandle] {
        &self.bodies
    }

    /// Their specifications in the cell file.
    pub(crate) fn specs(&self) -> &[ObjectSpec] {
        &self.specs
    }
}

/// Speed of its fastest point below which an object is at rest (m/s), and the speed for
/// objects that their cell allows to sleep while they tremble.
// Four cubes that stay awake cost 40 of 600 thousand instructions of a tick.
const REST_M_S: f64 = 1.0e-4;
const TREMBLE_M_S: f64 = 0.05;

/// Inserts every object, in the order of the cell. Parked ones are disabled. An object at rest
/// for half a second falls asleep with all that it touches, and wakes with it.
fn insert(world: &mut PhysicsWorld, cell: &Cell) -> Vec<RigidBodyHandle> {
    let objects = cell.objects.iter().enumerate().map(|(index, object)| {
        let builder = RigidBodyBuilder::dynamic()
            .pose(convert::to_pose(&object.pose))
            .angular_damping(object.angular_damping)
            // A disabled body costs nothing and is met by nothing until a device brings it.
            .enabled(!object.parked)
            .gyroscopic_forces_enabled(false);
        let mut body = builder.build();
        // Piles of round parts never come fully to rest: they tremble, and would stay awake
        // for ever.
        let speed = if object.sleeps { TREMBLE_M_S } else { REST_M_S };
        body.activation_mut().normalized_linear_threshold = speed / LENGTH_UNIT_M;
        let body = world.bodies.insert(body);
        let collider = collider(
            &object.shape,
            &Isometry3::identity(),
            object.friction,
            Tag::Object(index),
        )
        .mass(object.mass)
        // Friction along the slip (`engine::friction`).
        .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
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
