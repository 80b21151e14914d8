//! Objects outside of the cell: bins and parts that were not brought yet, and objects that
//! fell out. Their bodies are disabled, which costs nothing.

use serde::{Deserialize, Serialize};

use crate::engine::simulation::Engine;
use crate::gripper::grippers::Grippers;
use crate::operator::drag::Drags;

/// Objects outside of the cell: part of every snapshot.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Parking {
    /// Moved to their parking places in the last tick, to be disabled in this one.
    leaving: Vec<usize>,
    /// Counts objects put away.
    pub(super) cleared: u32,
    /// Objects that fell out and that only a reset brings back.
    pub(super) lost: Vec<usize>,
}

impl Parking {
    /// Takes what fell below `floor` (m) out of the cell: back to its parking place where
    /// something can bring it again.
    pub(super) fn clear_fallen(
        &mut self,
        engine: &mut Engine,
        grippers: &Grippers,
        drags: &mut Drags,
        floor: f64,
    ) {
        // Disabled one tick after the move, so that the engine takes in the new pose first.
        for object in std::mem::take(&mut self.leaving) {
            engine.park(object);
            if let Some(body) = engine.object_mut(object) {
                body.set_enabled(false);
            }
        }
        for object in 0..engine.objects().len() {
            let body = engine.object(object);
            let fallen = body.is_some_and(|b| b.is_enabled() && b.translation().z < floor);
            // An object on a cup is carried, however low: its joint would lose a body.
            if fallen && !grippers.is_attached(object) {
                drags.end(object);
                self.cleared = self.cleared.wrapping_add(1);
                if engine.specs().get(object).is_some_and(|s| s.parked) {
                    engine.park(object);
                    self.leaving.push(object);
                } else {
                    engine.take_out(object);
                    self.lost.push(object);
                }
            }
        }
    }
}
