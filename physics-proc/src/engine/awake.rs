//! Objects that must not sleep.

use rapier3d_f64::prelude::*;

use crate::engine::contacts::Contacts;
use crate::engine::objects::Objects;

/// Wakes objects that an arm touches: the engine would let a held object fall asleep
/// in a hand at rest.
pub(crate) fn wake_touched(engine: &mut PhysicsWorld, objects: &Objects, contacts: &Contacts) {
    let touched = objects.bodies.iter().zip(&contacts.touched);
    for (handle, _) in touched.filter(|(_, touched)| **touched) {
        let bodies = &mut engine.bodies;
        let sleeps = bodies.get(*handle).is_some_and(RigidBody::is_sleeping);
        // The engine examines every body that was borrowed to be changed.
        if sleeps && let Some(body) = bodies.get_mut(*handle) {
            body.wake_up(true);
        }
    }
}
