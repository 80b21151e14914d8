//! Objects that fell out of the cell and that only a reset brings back.

use crate::world::World;

impl World {
    /// Number of these objects.
    pub fn lost(&self) -> usize {
        self.memory.equipment.parking.lost.len()
    }

    /// Names of the lost objects after the first `known`; empty where there are none.
    pub fn lost_words(&self, known: usize) -> String {
        let lost = self.memory.equipment.parking.lost.iter().skip(known);
        let names = lost.filter_map(|object| self.objects.specs.get(*object));
        let names: Vec<String> = names.map(|spec| format!("'{}'", spec.name)).collect();
        if names.is_empty() {
            return String::new();
        }
        format!(
            "below z = {:.2} m an object is out of the cell until a reset: {}",
            self.equipment.clear_below,
            names.join(", ")
        )
    }
}

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
    pub(crate) fn look(&mut self, world: &World) {
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
