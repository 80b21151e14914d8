//! The conveyor: a fixture whose surface moves under what touches it.

use cell_model::cell::ConveyorTable;
use cell_model::{Cell, Shape};
use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d_f64::prelude::*;

use crate::convert;
use crate::objects::Fixtures;
use crate::settings::FRESH;
use crate::world::World;

/// The belt in the engine.
pub(crate) struct Belt {
    collider: ColliderHandle,
    /// Of its surface while it runs (m/s, world frame).
    velocity: Vector3<f64>,
    /// Its norm (m/s).
    pub(crate) speed: f64,
    pose: Isometry3<f64>,
    /// Half the lengths of the fixture along x and y (m).
    half: [f64; 2],
}

impl Belt {
    /// The belt of a cell; `None` where its fixture is not solid.
    pub(crate) fn new(table: &ConveyorTable, cell: &Cell, fixtures: &Fixtures) -> Option<Self> {
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

    /// Its contacts are computed anew in every tick, or they would go with what
    /// they carry.
    pub(crate) fn keep_fresh(&self, engine: &mut PhysicsWorld) {
        if let Some(collider) = engine.colliders.get_mut(self.collider) {
            collider.set_active_hooks(FRESH);
        }
    }

    /// Whether a point in the world is above it.
    pub(crate) fn is_below(&self, point: &Vector3<f64>) -> bool {
        let local = self.pose.inverse_transform_point(&Point3::from(*point));
        let [x, y] = self.half;
        local.x.abs() <= x && local.y.abs() <= y && local.z > 0.0
    }
}

/// What the engine asks in each step about contacts of colliders that are marked
/// with [`FRESH`].
///
/// Those are computed anew in every tick; the engine recycles the others, which
/// is 2.4 times cheaper in piles but lets a grasp slip. Where the belt runs,
/// what touches it is driven along.
pub(crate) struct Hooks {
    belt: Option<(ColliderHandle, Vector)>,
}

impl PhysicsHooks for Hooks {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let Some((belt, velocity)) = self.belt else {
            return;
        };
        // The engine counts the velocity of the first collider's surface.
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

impl World {
    /// The hooks of the tick that comes.
    pub(crate) fn hooks(&self) -> Hooks {
        let belt = self.equipment.belt.as_ref();
        let running = belt.filter(|_| self.memory.equipment.running);
        Hooks {
            belt: running.map(|belt| (belt.collider, convert::to_vector(&belt.velocity))),
        }
    }

    /// Nothing sleeps on a running belt.
    pub(crate) fn wake_belt(&mut self) {
        let Some(belt) = &self.equipment.belt else {
            return;
        };
        if !self.memory.equipment.running {
            return;
        }
        for handle in &self.objects {
            let bodies = &mut self.engine.bodies;
            let sleeps = bodies.get(*handle).is_some_and(|body| {
                let place = convert::from_vector(body.translation());
                body.is_enabled() && body.is_sleeping() && belt.is_below(&place)
            });
            if sleeps && let Some(body) = bodies.get_mut(*handle) {
                body.wake_up(true);
            }
        }
    }
}
