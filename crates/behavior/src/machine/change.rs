//! Leaving and entering states.

use super::actions::{Actions, Fault};
use super::ids::StateId;
use super::runtime::{Machine, Step};
use super::set::SmallSet;
use super::table::Table;
use super::trace::Happening;
use crate::status::{ResetReason, Status};

impl Machine {
    /// Goes to `dest`. Left is what is active beside the way to it; what both
    /// have in common stays. Returns what was entered.
    pub(super) fn change(
        &mut self,
        table: &Table,
        dest: StateId,
        transition: Happening,
        step: &Step,
        actions: &mut impl Actions,
    ) -> Result<SmallSet, Fault> {
        let leaving = self.leaving(table, dest);
        for rank in leaving.iter() {
            self.halt(table, rank, ResetReason::Aborted, actions);
            let exit = table.at(rank).map(|it| it.exit).unwrap_or_default();
            self.calls(exit, step, actions)?;
        }
        let kept = self.active.difference(&leaving);
        let entering = table.configuration(dest, &kept);
        self.active = kept.union(&entering);
        self.trace.add(transition);
        for rank in leaving.iter() {
            self.note(rank, Happening::Left);
        }
        for level in &table.levels {
            for rank in entering.intersection(level).iter() {
                self.finished.remove(rank);
                self.note(rank, Happening::Entered);
                let enter = table.at(rank).map(|it| it.enter).unwrap_or_default();
                self.calls(enter, step, actions)?;
            }
        }
        if self.status() != Status::Running {
            self.calls(table.common.on_final, step, actions)?;
        }
        Ok(entering)
    }

    /// Ranks of the states left on the way to `dest`.
    fn leaving(&self, table: &Table, dest: StateId) -> SmallSet {
        // The outermost state of the way that is not active yet; if all of it
        // is, the destination itself, which is then left and entered again.
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
            Some(parent) if parent.parallel => {
                let region = table.get(below).map(|it| it.subtree).unwrap_or_default();
                self.active.intersection(&region)
            }
            Some(parent) => {
                let mut inside = parent.subtree;
                inside.remove(parent.rank);
                self.active.intersection(&inside)
            }
            None => self.active,
        }
    }

    fn note(&mut self, rank: usize, happening: impl FnOnce(StateId) -> Happening) {
        if let Some(state) = self.table.by_rank.get(rank) {
            self.trace.add(happening(*state));
        }
    }

    /// Stops what a state runs.
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
        self.running.remove(rank);
        let during = table.at(rank).and_then(|it| it.during);
        if during.is_some_and(|during| !actions.halt(during.run, reason)) {
            self.halting.insert(rank);
        }
    }
}
