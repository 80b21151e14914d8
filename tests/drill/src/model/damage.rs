//! Files that are damaged while no process notices, until one starts on them, and messages that
//! are disturbed on their way.

use cell_bus::Disturbance;
use cell_rt::{Flipped, MemoryFile};
use ipc_types::topic::Process;

use super::{Model, News};
use crate::plan::Fault;

/// A file with a flipped bit.
pub(super) struct Damage {
    file: &'static str,
    of: Changed,
}

enum Changed {
    /// Of a file of slots.
    Bit(Flipped),
    /// Of a file that is replaced as a whole: its bytes.
    Bytes(Vec<u8>),
}

impl Model {
    /// Flips the bit of `file`, or of the next one that has a record, that `draw` chooses.
    pub fn damage_file(&mut self, file: &str, draw: u64) -> bool {
        // A second bit of a file could be the first one again.
        let damages = std::mem::take(&mut self.damages);
        let are_there = damages.into_iter().filter(|damage| self.still_has(damage));
        self.damages = are_there.collect();
        let is_whole = |file: &&&str| self.damages.iter().all(|of| of.file != **file);
        let first = Fault::FILES.iter().position(|name| *name == file);
        let from = Fault::FILES.iter().cycle().skip(first.unwrap_or(0));
        let all = from.take(Fault::FILES.len()).filter(is_whole);
        let damaged = { all }.find_map(|file| {
            let of = match self.file(file) {
                Some(slots) => Changed::Bit(slots.flip(draw)?),
                None => Changed::Bytes(self.disk.flip(draw)?),
            };
            Some(Damage { file, of })
        });
        let is_damaged = damaged.is_some();
        self.damages.extend(damaged);
        is_damaged
    }

    /// Lets `disturbance` happen to the next message of the topic called `name`.
    pub fn disturb(&self, name: &str, disturbance: Disturbance) -> bool {
        let topic = crate::plan::topic(name, self.spec.arms);
        topic.is_some_and(|topic| self.site.disturb(topic, disturbance))
    }

    /// The file of slots with this name.
    fn file(&self, name: &str) -> Option<&MemoryFile> {
        match name {
            "physics.requests" => Some(&self.requests),
            "task.slots" => Some(&self.task_files.newest),
            "task.history" => Some(&self.task_files.history),
            _ => None,
        }
    }

    /// Whether nothing was written in its place since.
    fn still_has(&self, damage: &Damage) -> bool {
        match &damage.of {
            Changed::Bit(flipped) => {
                let file = self.file(damage.file);
                file.is_some_and(|file| file.still_has(flipped))
            }
            Changed::Bytes(bytes) => self.disk.still_has(bytes),
        }
    }

    /// `process` is about to read its files.
    pub(super) fn meet_damage(&mut self, process: Process) {
        let damages = std::mem::take(&mut self.damages);
        let (read, other): (Vec<Damage>, _) = damages
            .into_iter()
            .partition(|damage| damage.file.starts_with(&process.name()));
        self.damages = other;
        for damage in read {
            if !self.still_has(&damage) {
                continue;
            }
            let tick = match damage.of {
                Changed::Bit(_) => 0,
                Changed::Bytes(_) => self.disk.tick(),
            };
            self.news.push(News::Meets(process, damage.file, tick));
        }
    }
}
