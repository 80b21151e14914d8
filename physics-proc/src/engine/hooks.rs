//! Changes to each contact before the engine solves it: the velocity of a belt's surface, and
//! the direction of friction.

use rapier3d_f64::prelude::*;

use crate::engine::friction::{self, Side, Tangents};
use crate::engine::tag::Tag;

/// Called by the engine in each step for contacts of objects.
pub(crate) struct Hooks {
    /// A belt that runs, and the velocity of its surface (m/s, world frame).
    belt: Option<(ColliderHandle, Vector)>,
}

impl Hooks {
    /// The hooks of the next tick; `belt` is the one that runs.
    pub(crate) fn new(belt: Option<(ColliderHandle, Vector)>) -> Self {
        Self { belt }
    }

    /// Velocity of the surface of the first collider against that of the second one.
    fn surface(&self, context: &ContactModificationContext<'_>) -> Vector {
        match self.belt {
            Some((belt, velocity)) if context.collider1 == belt => velocity,
            Some((belt, velocity)) if context.collider2 == belt => -velocity,
            _ => Vector::ZERO,
        }
    }
}

impl PhysicsHooks for Hooks {
    fn modify_solver_contacts(&self, context: &mut ContactModificationContext<'_>) {
        let (surface, touches_arm) = (self.surface(context), touches_arm(context));
        let bodies = context.bodies;
        let free = |body: Option<RigidBodyHandle>, sign: f64| -> Option<Side<'_>> {
            let body = bodies.get(body?)?;
            body.is_dynamic().then_some((body, sign))
        };
        let sides = [
            free(context.rigid_body1, 1.0),
            free(context.rigid_body2, -1.0),
        ];
        let Some(manifold) = context.rigid_mut() else {
            return;
        };
        let tangents = Tangents::new(*manifold.normal);
        for contact in manifold.solver_contacts.iter_mut() {
            let point = (contact.anchor1 + contact.anchor2) * 0.5;
            contact.tangent_velocity = surface;
            if !touches_arm {
                let along = friction::along_slip(&sides, &tangents, point, surface);
                contact.tangent_velocity += along;
            }
        }
    }
}

/// Whether a link of an arm is one of the two. The engine solves these contacts in the
/// coordinates of the joints, with a mass that is not that of the body.
fn touches_arm(context: &ContactModificationContext<'_>) -> bool {
    let is_link = |collider: ColliderHandle| {
        let collider = context.colliders.get(collider);
        collider.is_some_and(|of| matches!(Tag::decode(of.user_data), Tag::Link { .. }))
    };
    is_link(context.collider1) || is_link(context.collider2)
}
