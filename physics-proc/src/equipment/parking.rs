//! Objects outside of the cell: bins and parts that were not brought yet, and objects that
//! fell out. Their bodies are disabled, which costs nothing.

use serde::{Deserialize, Serialize};

use crate::equipment::site::Site;

/// Objects outside of the cell.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ParkingMemory {
    /// Moved to their parking places in the last tick, to be disabled in this one.
    leaving: Vec<usize>,
    /// Counts objects put away.
    pub(crate) cleared: u32,
    /// Objects that fell out and that only a reset brings back.
    pub(crate) lost: Vec<usize>,
}

impl ParkingMemory {
    /// Takes what fell below `floor` (m) out of the cell: back to its parking place where
    /// something can bring it again.
    pub(crate) fn clear_fallen(&mut self, site: &mut Site<'_>, floor: f64) {
        // Disabled one tick after the move, so that the engine takes in the new pose first.
        for object in std::mem::take(&mut self.leaving) {
            site.rest_at_its_place(object);
            if let Some(body) = site.objects.body_mut(site.engine, object) {
                body.set_enabled(false);
            }
        }
        for object in 0..site.objects.bodies.len() {
            let body = site.objects.body(site.engine, object);
            let fallen = body.is_some_and(|b| b.is_enabled() && b.translation().z < floor);
            // An object on a cup is carried, however low: its joint would lose a body.
            if fallen && !site.is_attached(object) {
                site.drags.retain(|drag| drag.object != object);
                self.cleared = self.cleared.wrapping_add(1);
                if site.objects.specs.get(object).is_some_and(|s| s.parked) {
                    site.rest_at_its_place(object);
                    self.leaving.push(object);
                } else {
                    site.take_out(object);
                    self.lost.push(object);
                }
            }
        }
    }
}
