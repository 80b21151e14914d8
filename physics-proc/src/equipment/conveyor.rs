//! The conveyor: a fixture whose surface moves the objects on it.

use cell_model::cells::cell::ConveyorTable;
use cell_model::{Cell, Shape};
use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::objects::Fixtures;
use crate::engine::simulation::Engine;

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

    /// Makes the engine call [`Hooks`] for contacts of the belt.
    pub(super) fn drive_contacts(&self, engine: &mut PhysicsWorld) {
        if let Some(collider) = engine.colliders.get_mut(self.collider) {
            collider.set_active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS);
        }
    }

    /// Whether a point in the world is above it.
    pub(super) fn is_below(&self, point: &Vector3<f64>) -> bool {
        let local = self.pose.inverse_transform_point(&Point3::from(*point));
        let [x, y] = self.half;
        local.x.abs() <= x && local.y.abs() <= y && local.z > 0.0
    }

    /// Wakes objects on the belt: a sleeping one would not be moved.
    pub(super) fn wake(&self, engine: &mut Engine) {
        engine.wake(|_, body| {
            let place = convert::from_vector(body.translation());
            body.is_enabled() && self.is_below(&place)
        });
    }
}

/// Called by the engine in each step for contacts of the belt: while it runs, their surface
/// velocity moves the objects.
pub(crate) struct Hooks {
    belt: Option<(ColliderHandle, Vector)>,
}

impl PhysicsHooks for Hooks {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let Some((belt, velocity)) = self.belt else {
            return;
        };
        // The engine applies the velocity to the surface of the first collider.
        let velocity = if context.collider1 == belt {
            velocity
        } else if context.collider2 == belt {
            -velocity
        } else {
            return;
        };
        if let Some(manifold) = context.rigid_mut() {
            for contact in manifold.solver_contacts.iter_mut() {
                contact.tangent_velocity = velocity;
            }
        }
    }
}

impl Hooks {
    /// The hooks of the next tick; `belt` is the running belt.
    pub(super) fn new(belt: Option<&Belt>) -> Self {
        Self {
            belt: belt.map(|belt| (belt.collider, convert::to_vector(&belt.velocity))),
        }
    }
}
