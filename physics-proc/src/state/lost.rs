//! Objects that fell out of the cell and that only a reset brings back.

use crate::world::World;

/// Reports lost objects once each.
pub(crate) struct LostNews {
    known: usize,
    /// For the health report; empty if no object is lost.
    pub(crate) words: String,
}

impl LostNews {
    /// The reports of a process that starts with `world`.
    pub(crate) fn new(world: &World) -> Self {
        Self {
            known: world.lost(),
            words: world.lost_words(0),
        }
    }

    /// Reports each new lost object once in the log.
    pub(crate) fn report(&mut self, world: &World) {
        let known = std::mem::replace(&mut self.known, world.lost());
        if known == self.known {
            return;
        }
        self.words = world.lost_words(0);
        if known < self.known {
            cell_worker::warn(world.lost_words(known));
        }
    }
}
