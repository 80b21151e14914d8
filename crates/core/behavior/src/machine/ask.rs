//! The effect of a trigger, found by its guards, without a change.

use super::actions::Actions;
use super::guards::{Memo, holds};
use super::ids::TriggerId;
use super::runtime::Machine;
use super::set::SmallSet;

impl Machine {
    /// Whether `trigger` would take a row now. Evaluates guards; nothing else runs
    /// and nothing is stored.
    pub fn may(&self, trigger: TriggerId, actions: &mut impl Actions) -> bool {
        let mut memo = Memo::default();
        self.active.iter().any(|rank| {
            self.table
                .rows_of(trigger, rank)
                .iter()
                .any(|row| holds(&self.table, row, &mut memo, actions, &mut |_| {}))
        })
    }

    /// Whether `trigger` would now take only rows that lead to active states, which would be
    /// left and entered again, or internal rows. For a host whose triggers are conditions,
    /// which stay true for many decisions.
    pub fn stays(&self, trigger: TriggerId, actions: &mut impl Actions) -> bool {
        let mut memo = Memo::default();
        let (mut done, mut any) = (SmallSet::default(), false);
        // In the order of `process`, so that both find the same rows.
        for rank in self.active.iter() {
            if done.contains(rank) {
                continue;
            }
            let mut rows = self.table.rows_of(trigger, rank).iter();
            let Some(row) =
                rows.find(|row| holds(&self.table, row, &mut memo, actions, &mut |_| {}))
            else {
                continue;
            };
            // One row that leads elsewhere is enough: the trigger has an effect.
            if row.dest.is_some_and(|dest| !self.is_active(dest)) {
                return false;
            }
            any = true;
            // A state inside has taken the trigger, so the states around it are not tried.
            done = done.union(&self.table.at(rank).map(|it| it.path).unwrap_or_default());
        }
        any
    }
}
