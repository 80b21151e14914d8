//! The guards of a row, each evaluated once per trigger.

use super::actions::Actions;
use super::ids::GuardId;
use super::set::SmallSet;
use super::table::{Row, Table};
use super::trace::Happening;

/// Guards that were evaluated for this trigger, and their results.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memo {
    // Two sets, since "not evaluated" and "does not hold" are different answers.
    known: SmallSet,
    holding: SmallSet,
}

impl Memo {
    fn get(&self, guard: GuardId) -> Option<bool> {
        self.known
            .contains(guard.index())
            .then(|| self.holding.contains(guard.index()))
    }

    fn put(&mut self, guard: GuardId, value: bool) {
        self.known.insert(guard.index());
        if value {
            self.holding.insert(guard.index());
        }
    }
}

/// Whether all guards of a row have the required result, evaluated from left to right up to
/// the first that does not.
pub(super) fn holds(
    table: &Table,
    row: &Row,
    memo: &mut Memo,
    actions: &mut impl Actions,
    trace: &mut impl FnMut(Happening),
) -> bool {
    row.conditions
        .of(&table.conditions)
        .iter()
        .all(|condition| {
            let guard = condition.guard;
            // At most once per trigger: of two rows with opposite guards exactly one is taken,
            // also if the guard reads something that changes meanwhile.
            let value = memo.get(guard).unwrap_or_else(|| {
                let value = actions.guard(guard);
                memo.put(guard, value);
                trace(Happening::Guard { guard, value });
                value
            });
            value == condition.expected
        })
}
