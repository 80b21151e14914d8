//! The conveyor: a fixture whose surface moves the objects on it.

use cell_model::cells::cell::ConveyorTable;
use cell_model::{Cell, Shape};
use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d_f64::prelude::*;

use crate::engine::contacts::partner;
use crate::engine::convert;
use crate::engine::objects::Fixtures;
use crate::engine::simulation::Engine;
use crate::engine::tag::Tag;

/// The belt in the engine.
pub(crate) struct Belt {
    collider: ColliderHandle,
    /// Velocity of its surface while it runs (m/s, world frame).
    velocity: Vector3<f64>,
    /// Its norm (m/s).
    pub(super) speed: f64,
    pose: Isometry3<f64>,
    /// Half the lengths of the fixture along x and y (m).
    half: [f64; 2],
}

impl Belt {
    /// The belt of a cell; `None` where its fixture is not solid.
    pub(super) fn new(table: &ConveyorTable, cell: &Cell, fixtures: &Fixtures) -> Option<Self> {
        let index = cell
            .fixtures
            .iter()
            .position(|fixture| fixture.name == table.fixture)?;
        let fixture = cell.fixtures.get(index)?;
        let half = match fixture.shape {
            Shape::Box { size_m: [x, y, _] } => [0.5 * x, 0.5 * y],
            ref other => [other.bounding_radius(); 2],
        };
        let velocity = Vector3::from(table.velocity_m_s);
        Some(Self {
            collider: (*fixtures.colliders.get(index)?)?,
            velocity,
            speed: velocity.norm(),
            pose: fixture.pose,
            half,
        })
    }

    /// Makes the engine call [`crate::engine::hooks::Hooks`] for contacts of the belt with arms,
    /// too.
    pub(super) fn drive_contacts(&self, engine: &mut PhysicsWorld) {
        if let Some(collider) = engine.colliders.get_mut(self.collider) {
            collider.set_active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
    }

    /// Its collider, and the velocity of its surface while it runs (m/s, world frame).
    pub(super) fn surface(&self) -> (ColliderHandle, Vector) {
        (self.collider, convert::to_vector(&self.velocity))
    }

    /// Whether a point in the world is above the belt, at most `height` above the middle of its
    /// fixture (m).
    pub(super) fn is_below(&self, point: &Vector3<f64>, height: f64) -> bool {
        let local = self.pose.inverse_transform_point(&Point3::from(*point));
        let [x, y] = self.half;
        local.x.abs() <= x && local.y.abs() <= y && local.z > 0.0 && local.z <= height
    }

    /// Height of a point above the middle of the belt's fixture (m).
    pub(super) fn height_of(&self, point: &Vector3<f64>) -> f64 {
        let local = self.pose.inverse_transform_point(&Point3::from(*point));
        local.z
    }

    /// The objects that touch the belt or nearly do, also those that sleep.
    pub(super) fn touching(&self, engine: &Engine) -> Vec<usize> {
        let rapier = engine.rapier();
        let pairs = rapier.narrow_phase.contact_pairs_with(self.collider);
        let tags = pairs.filter_map(|pair| {
            let other = rapier.colliders.get(partner(pair, self.collider))?;
            Some(Tag::decode(other.user_data))
        });
        let mut objects: Vec<usize> = tags
            .filter_map(|tag| match tag {
                Tag::Object(object) => Some(object),
                Tag::Fixture(_) | Tag::Link { .. } => None,
            })
            .collect();
        // The order of the engine's pairs is that in which it found them.
        objects.sort_unstable();
        objects
    }

    /// Wakes the objects on the belt: a sleeping one would not be moved.
    pub(super) fn wake(&self, engine: &mut Engine) {
        let touching = self.touching(engine);
        engine.wake(|object, body| body.is_enabled() && touching.binary_search(&object).is_ok());
    }
}
