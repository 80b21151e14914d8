//! Which contacts are computed anew in every tick, and who may not sleep.

use rapier3d_f64::prelude::*;

use crate::settings::{FEW_OBJECTS, FRESH};
use crate::world::World;

impl World {
    /// Contacts of held objects are computed anew in every tick, as those of
    /// the hand; where there are few objects, those of all but bins and parts,
    /// which stand still without. What is touched stays awake.
    pub(crate) fn refresh_held(&mut self) {
        let few = self.objects.len() <= FEW_OBJECTS;
        for index in 0..self.objects.len() {
            let grips = &self.contacts.grips;
            let held = grips.iter().any(|grip| grip.held == Some(index)) || self.is_attached(index);
            let spec = self.equipment.specs.get(index);
            let alone = spec.is_some_and(|spec| !spec.is_bin() && !spec.parked);
            let hooks = if held || (few && alone) {
                FRESH
            } else {
                ActiveHooks::empty()
            };
            let touched = self.contacts.touched.get(index) == Some(&true);
            let handle = self.objects.get(index);
            let Some(handle) = handle.copied() else {
                continue;
            };
            // The engine looks at whatever was borrowed from it to be changed.
            let bodies = &mut self.engine.bodies;
            let sleeps = bodies.get(handle).is_some_and(RigidBody::is_sleeping);
            if touched
                && sleeps
                && let Some(body) = bodies.get_mut(handle)
            {
                body.wake_up(true);
            }
            for collider in bodies.get(handle).map_or(&[][..], RigidBody::colliders) {
                let colliders = &mut self.engine.colliders;
                let differs = colliders
                    .get(*collider)
                    .is_some_and(|c| c.active_hooks() != hooks);
                if let Some(collider) = colliders.get_mut(*collider).filter(|_| differs) {
                    collider.set_active_hooks(hooks);
                }
            }
        }
    }
}
