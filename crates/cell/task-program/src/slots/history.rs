//! The history: checkpoints for the states that physics saved.

use robocell_task::checkpoint;
use robocell_task::starts::{History, Kept};

use super::{HEAD_BYTES, HISTORY, Head, Slots, note};

impl Slots {
    /// Slots of the history with the newest entries first, without those of a timeline that
    /// physics left when it resumed from an earlier state.
    fn on_this_timeline(&self) -> Vec<(usize, u64)> {
        let labels = self.labels.iter().enumerate();
        let mut slots: Vec<_> = labels
            .filter_map(|(slot, label)| label.map(|(label, seq)| (slot, label, seq)))
            .collect();
        slots.sort_by_key(|(.., seq)| core::cmp::Reverse(*seq));
        let mut earliest = u64::MAX;
        // By number of the entry, not by tick. An older entry with a tick that is not smaller
        // was written before physics went back.
        let is_current = move |(_, label, _): &(usize, u64, u64)| {
            let is_current = *label < earliest;
            earliest = earliest.min(*label);
            is_current
        };
        let slots = slots.into_iter().filter(is_current);
        slots.map(|(slot, label, _)| (slot, label)).collect()
    }

    /// The slot with the entry for the state of `tick`, and its label.
    fn find(&self, tick: u64) -> Option<(usize, u64)> {
        let slots = self.on_this_timeline();
        // The newest that is not after `tick`: a younger one contains decisions of the future.
        slots.into_iter().find(|(_, label)| *label <= tick)
    }

    fn read_history(&self, slot: usize, label: u64) -> Option<Kept> {
        let (.., bytes) = self
            .history
            .all_slots()
            .find(|(found, ..)| *found == slot)?;
        let (_, saved) = self.entry(&bytes)?;
        Some(Kept {
            tick: label,
            checkpoint: saved.checkpoint,
        })
    }
}

impl History for Slots {
    fn at(&self, tick: u64) -> Option<Kept> {
        // An exact entry first: it was written for this very state.
        let found = self.find(tick);
        if let Some((slot, label)) = found.filter(|(_, label)| *label == tick) {
            return self.read_history(slot, label);
        }
        // Then the newest checkpoint, if it is not after the state: it is younger than any
        // entry of the history that could be found.
        let newest = self.file.newest();
        let newest = newest.and_then(|(_, bytes)| self.entry(&bytes));
        if let Some((head, saved)) = newest.filter(|(head, _)| head.tick <= tick) {
            return Some(Kept {
                tick: head.tick,
                checkpoint: saved.checkpoint,
            });
        }
        let (slot, label) = found?;
        self.read_history(slot, label)
    }

    /// The checkpoint is the entry written last.
    fn keep(&mut self, tick: u64, saved_tick: u64, _checkpoint: &dyn Fn() -> Vec<u8>) {
        if self.buffer.is_empty() {
            // The entry is of the process before this one.
            self.buffer = self.file.newest().unwrap_or_default().1;
        }
        let head = self
            .buffer
            .get(..HEAD_BYTES)
            .map(checkpoint::from_bytes::<Head>);
        // A checkpoint that is too long was not written, and was reported.
        let Some(Ok(mut head)) = head else {
            return;
        };
        // The task has an older memory than its newest entry: physics went back, and this entry is
        // of decisions that have not happened.
        if head.tick > tick {
            return;
        }
        head.label = tick;
        self.buffer
            .splice(..HEAD_BYTES, checkpoint::to_bytes(&head));
        // The entry for the state that physics would resume from now stays, however old it is:
        // a kill before the new state is complete needs it.
        let needed = self.find(saved_tick).map(|(slot, _)| slot);
        let slots = (0..HISTORY).filter(|slot| Some(*slot) != needed);
        // Empty slots have no number, which is less than any, so they are used first.
        let number = |slot: &usize| {
            self.labels
                .get(*slot)
                .copied()
                .flatten()
                .map(|(_, seq)| seq)
        };
        let Some(oldest) = slots.min_by_key(number) else {
            return;
        };
        self.history_seq += 1;
        let written = self
            .history
            .write_at(oldest, self.history_seq, &self.buffer);
        // A failed write has an unknown content: the slot counts as empty.
        if let Some(label) = self.labels.get_mut(oldest) {
            *label = written.is_ok().then_some((tick, self.history_seq));
        }
        let written = written.map_err(|error| error.to_string());
        note(
            &mut self.history_problem,
            "the task, after a kill of physics,",
            written,
        );
    }
}
