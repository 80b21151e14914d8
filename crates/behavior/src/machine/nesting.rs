//! States that run a sub-behaviour while they are active.

use std::sync::Arc;

use super::actions::Actions;
use super::runtime::{Machine, TriggerError};
use super::table::During;
use super::trace::Happening;
use crate::status::{ResetReason, Status};

impl Machine {
    /// Ticks the sub-behaviours of the active states once, and fires the
    /// trigger of each that finishes. A finished one rests until its state is
    /// entered again. Does nothing for a machine without sub-behaviours.
    ///
    /// # Errors
    /// As [`Machine::trigger`], for the first trigger that fails.
    pub fn tick(&mut self, actions: &mut impl Actions) -> Result<Status, TriggerError> {
        let table = Arc::clone(&self.table);
        for rank in self.halting.iter() {
            let during = table.at(rank).and_then(|it| it.during);
            if during.is_none_or(|during| actions.halt(during.run, ResetReason::Aborted)) {
                self.halting.remove(rank);
            }
        }
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

    /// Stops everything that runs, and goes back to the initial state without
    /// running its callbacks. Answers whether all has stopped; until it has,
    /// call it again.
    pub fn halt_all(&mut self, reason: ResetReason, actions: &mut impl Actions) -> bool {
        let table = Arc::clone(&self.table);
        let stopping = std::mem::take(&mut self.halting);
        self.running = self.running.union(&stopping);
        for rank in self.running.iter() {
            self.halt(&table, rank, reason, actions);
        }
        let still = self.halting;
        self.set_state(table.initial);
        self.halting = still;
        still.is_empty()
    }
}
