//! Objects that are not in the cell: bins and parts that have not come yet, and
//! what fell out. Their bodies are disabled, which costs nothing.

use serde::{Deserialize, Serialize};

use crate::equipment::site::Site;

/// Who is on the way out.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct ParkingMemory {
    /// Moved to their parking places in the last tick, to be disabled in this.
    leaving: Vec<usize>,
    /// Counts objects put away.
    pub(crate) cleared: u32,
}

impl ParkingMemory {
    /// Puts what fell below `floor` (m) back to its parking place.
    pub(crate) fn clear_fallen(&mut self, site: &mut Site<'_>, floor: Option<f64>) {
        for object in std::mem::take(&mut self.leaving) {
            site.rest_at_its_place(object);
            if let Some(body) = site.objects.body_mut(site.engine, object) {
                body.set_enabled(false);
            }
        }
        let Some(floor) = floor else {
            return;
        };
        for object in 0..site.objects.bodies.len() {
            let body = site.objects.body(site.engine, object);
            let fallen = body.is_some_and(|b| b.is_enabled() && b.translation().z < floor);
            if fallen && !site.is_attached(object) {
                self.park(object, site);
            }
        }
    }

    fn park(&mut self, object: usize, site: &mut Site<'_>) {
        site.rest_at_its_place(object);
        site.drags.retain(|drag| drag.object != object);
        self.leaving.push(object);
        self.cleared = self.cleared.wrapping_add(1);
    }
}
