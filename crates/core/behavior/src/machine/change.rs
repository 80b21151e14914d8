//! Transitions: states are left and entered.

use super::actions::{Actions, Fault};
use super::ids::StateId;
use super::runtime::{Machine, Step};
use super::set::SmallSet;
use super::table::Table;
use super::trace::Happening;
use crate::status::{ResetReason, Status};

impl Machine {
    /// Changes to `dest`. All active states that do not contain it are left; common parents
    /// stay active. Returns the entered states.
    pub(super) fn change(
        &mut self,
        table: &Table,
        dest: StateId,
        transition: Happening,
        step: &Step,
        actions: &mut impl Actions,
    ) -> Result<SmallSet, Fault> {
        // Computed before any callback runs: callbacks see one state, and cannot change the
        // set.
        let leaving = self.leaving(table, dest);
        for rank in leaving.iter() {
            // Sub-behaviours stop before the exit callback, which may command the arm itself.
            self.halt(table, rank, ResetReason::Aborted, actions);
            let exit = table.at(rank).map(|it| it.exit).unwrap_or_default();
            self.calls(exit, step, actions)?;
        }
        // The exit callbacks have succeeded. A fault in one leaves the machine in the source,
        // never between two states.
        let kept = self.active.difference(&leaving);
        let entering = table.configuration(dest, &kept);
        self.active = kept.union(&entering);
        self.trace.add(transition);
        for rank in leaving.iter() {
            self.note(rank, Happening::Left);
        }
        // Outermost first, as the states around are the context of those inside.
        for level in &table.levels {
            for rank in entering.intersection(level).iter() {
                // A sub-behaviour that finished in an earlier visit runs again.
                self.finished.remove(rank);
                self.note(rank, Happening::Entered);
                let enter = table.at(rank).map(|it| it.enter).unwrap_or_default();
                self.calls(enter, step, actions)?;
            }
        }
        // Final only after all of it was entered: an enter callback may still fail.
        if self.status() != Status::Running {
            self.calls(table.common.on_final, step, actions)?;
        }
        Ok(entering)
    }

    /// Ranks of the states that a change to `dest` leaves.
    fn leaving(&self, table: &Table, dest: StateId) -> SmallSet {
        // The outermost state on the way to `dest` that is not active yet; if all are active,
        // the destination itself, which is then left and entered again.
        let mut below = dest;
        let mut above = table.get(dest).and_then(|it| it.parent);
        while let Some(parent) = above.and_then(|parent| table.get(parent).zip(above)) {
            let (it, id) = parent;
            if self.active.contains(it.rank) {
                break;
            }
            below = id;
            above = it.parent;
        }
        let parallel = above.and_then(|parent| table.get(parent));
        match parallel {
            // Only the region with the destination is left; the other regions stay active.
            Some(parent) if parent.parallel => {
                let region = table.get(below).map(|it| it.subtree).unwrap_or_default();
                self.active.intersection(&region)
            }
            Some(parent) => {
                let mut inside = parent.subtree;
                // The parent itself stays active, all that is active inside is left.
                inside.remove(parent.rank);
                self.active.intersection(&inside)
            }
            // No common parent: the whole configuration changes.
            None => self.active,
        }
    }

    fn note(&mut self, rank: usize, happening: impl FnOnce(StateId) -> Happening) {
        if let Some(state) = self.table.by_rank.get(rank) {
            self.trace.add(happening(*state));
        }
    }

    /// Stops the sub-behaviour of a state.
    pub(super) fn halt(
        &mut self,
        table: &Table,
        rank: usize,
        reason: ResetReason,
        actions: &mut impl Actions,
    ) {
        if !self.running.contains(rank) {
            return;
        }
        // Not running from here on, even if it needs more calls to stop: it must not be ticked.
        self.running.remove(rank);
        let during = table.at(rank).and_then(|it| it.during);
        if during.is_some_and(|during| !actions.halt(during.run, reason)) {
            self.halting.insert(rank);
        }
    }
}
