//! States that run a sub-behaviour while they are active.

use std::sync::Arc;

use super::actions::Actions;
use super::runtime::{Machine, TriggerError};
use super::table::During;
use super::trace::Happening;
use crate::status::{ResetReason, Status};

impl Machine {
    /// Ticks the sub-behaviours of the active states once, and fires the
    /// trigger of each that finishes. A finished one is not ticked until its state is
    /// entered again. Does nothing for a machine without sub-behaviours.
    ///
    /// # Errors
    /// As [`Machine::trigger`], for the first trigger that fails.
    pub fn tick(&mut self, actions: &mut impl Actions) -> Result<Status, TriggerError> {
        let table = Arc::clone(&self.table);
        // First those that are still stopping: until one has stopped, its state may be entered
        // again but does not run it.
        for rank in self.halting.iter() {
            let during = table.at(rank).and_then(|it| it.during);
            if during.is_none_or(|during| actions.halt(during.run, ResetReason::Aborted)) {
                self.halting.remove(rank);
            }
        }
        // The set is taken before the first trigger: a state that is entered in this tick
        // starts its sub-behaviour in the next one.
        let begun = self.active.intersection(&table.during);
        for rank in begun.iter() {
            if let Some(during) = table.at(rank).and_then(|it| it.during) {
                self.run(rank, during, actions)?;
            }
        }
        Ok(self.status())
    }

    fn run(
        &mut self,
        rank: usize,
        during: During,
        actions: &mut impl Actions,
    ) -> Result<(), TriggerError> {
        let waits = self.halting.contains(rank) || self.finished.contains(rank);
        // A trigger of an earlier sub-behaviour in this tick may have left the state.
        if waits || !self.active.contains(rank) {
            return Ok(());
        }
        self.running.insert(rank);
        let status = actions.run(during.run);
        let fires = match status {
            Status::Running => return Ok(()),
            Status::Success => during.success,
            Status::Failure => during.failure,
        };
        // Marked before the trigger, whose row may enter the state again and clear the mark.
        self.running.remove(rank);
        self.finished.insert(rank);
        self.trace.add(Happening::Finished {
            behavior: during.run,
            status,
        });
        match fires {
            Some(trigger) => self.trigger(trigger, actions).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Stops all sub-behaviours, and resets the machine to the initial state without
    /// callbacks. Returns whether all have stopped; until then it has to be called
    /// again.
    pub fn halt_all(&mut self, reason: ResetReason, actions: &mut impl Actions) -> bool {
        let table = Arc::clone(&self.table);
        // Those that are stopping already are stopped again with the others.
        let stopping = std::mem::take(&mut self.halting);
        self.running = self.running.union(&stopping);
        for rank in self.running.iter() {
            self.halt(&table, rank, reason, actions);
        }
        let still = self.halting;
        // `set_state` clears the set, and those that have not stopped must not be lost.
        self.set_state(table.initial);
        self.halting = still;
        still.is_empty()
    }
}
