//! Which contacts are recomputed in every tick, and which bodies may not sleep.

use rapier3d_f64::prelude::*;

use crate::engine::contacts::Contacts;
use crate::engine::objects::Objects;
use crate::engine::settings::{FEW_OBJECTS, FRESH};

/// Contacts of held objects are recomputed in every tick, as those of the
/// hand; where there are few objects, those of all but bins and parts, which
/// stand still without. What is touched stays awake. `attached` says which
/// objects a cup has.
pub(crate) fn refresh(
    engine: &mut PhysicsWorld,
    objects: &Objects,
    contacts: &Contacts,
    attached: impl Fn(usize) -> bool,
) {
    let few = objects.bodies.len() <= FEW_OBJECTS;
    for (index, (handle, spec)) in objects.bodies.iter().zip(&objects.specs).enumerate() {
        let gripped = contacts.grips.iter().any(|grip| grip.held == Some(index));
        let alone = !spec.is_bin() && !spec.parked;
        let hooks = if gripped || attached(index) || (few && alone) {
            FRESH
        } else {
            ActiveHooks::empty()
        };
        let touched = contacts.touched.get(index) == Some(&true);
        // The engine looks at whatever was borrowed from it to be changed.
        let bodies = &mut engine.bodies;
        let sleeps = bodies.get(*handle).is_some_and(RigidBody::is_sleeping);
        if touched
            && sleeps
            && let Some(body) = bodies.get_mut(*handle)
        {
            body.wake_up(true);
        }
        for collider in bodies.get(*handle).map_or(&[][..], RigidBody::colliders) {
            let colliders = &mut engine.colliders;
            // One that is borrowed to be changed costs the engine a look at all its pairs.
            let differs = colliders
                .get(*collider)
                .is_some_and(|c| c.active_hooks() != hooks);
            if differs && let Some(collider) = colliders.get_mut(*collider) {
                collider.set_active_hooks(hooks);
            }
        }
    }
}
