//! The load on a suction cup from the motion of its objects: each change of their momentum
//! that is caused neither by gravity nor by a drag is the force of the cup.
//!
//! The engine keeps a joint's impulses of its last substep only. While the arm
//! moves its drives see a target that steps once in a tick, so they push in the
//! first substep and slacken to the last: at 0.3 m/s the last one alone reads 7 %
//! too little (measured). Momentum over the tick has all of them.

use nalgebra::{Isometry3, Vector3};
use rapier3d_f64::prelude::*;

use crate::engine::convert;
use crate::engine::settings::{GRAVITY, TICK_S};

/// Velocities of all objects right before a step (m/s and rad/s, world frame).
#[derive(Debug, Default)]
pub(crate) struct Velocities(Vec<[Vector3<f64>; 2]>);

impl Velocities {
    /// As they are now.
    pub(crate) fn note(&mut self, engine: &PhysicsWorld, objects: &[RigidBodyHandle]) {
        self.0.clear();
        let now = objects.iter().map(|handle| {
            engine.bodies.get(*handle).map_or_else(
                || [Vector3::zeros(); 2],
                |body| [body.linvel(), body.angvel()].map(convert::from_vector),
            )
        });
        self.0.extend(now);
    }

    /// Mean load of the step on a cup at `cup` (world frame) that holds the objects
    /// `hanging`, which touch nothing else: force (N) and torque about the cup
    /// (N·m) in the frame of the cup.
    pub(crate) fn load(
        &self,
        engine: &PhysicsWorld,
        objects: &[RigidBodyHandle],
        hanging: &[usize],
        cup: &Isometry3<f64>,
    ) -> Option<[f64; 6]> {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for index in hanging {
            let body = engine.bodies.get(*objects.get(*index)?)?;
            let [push, turn] = given(body, self.0.get(*index)?);
            let arm = convert::from_vector(body.center_of_mass()) - cup.translation.vector;
            force += push;
            torque += turn + arm.cross(&push);
        }
        // The force of the cup on the objects is the load on the cup with the opposite sign.
        let (force, torque) = (
            cup.rotation.inverse() * -force,
            cup.rotation.inverse() * -torque,
        );
        Some([force.x, force.y, force.z, torque.x, torque.y, torque.z])
    }
}

/// Force (N) and torque about its centre of mass (N·m) that `body` was given in the
/// step besides gravity and forces from outside.
fn given(body: &RigidBody, before: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let [moved, turned] = [body.linvel(), body.angvel()].map(convert::from_vector);
    let acceleration = (moved - before[0]) / TICK_S;
    let gravity = Vector3::from(GRAVITY) * body.gravity_scale();
    let outside = convert::from_vector(body.user_force());
    let force = (acceleration - gravity) * body.mass() - outside;
    // The engine turns objects without gyroscopic torques, so none are subtracted here.
    let to_world = *body.rotation();
    let change = convert::to_vector(&((turned - before[1]) / TICK_S));
    let local = body
        .mass_properties()
        .local_mprops
        .reconstruct_inertia_matrix()
        * (to_world.inverse() * change);
    let torque = convert::from_vector(to_world * local - body.user_torque());
    [force, torque]
}
