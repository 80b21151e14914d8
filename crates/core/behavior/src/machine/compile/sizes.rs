//! Limits on the number of states, rows and triggers, checked before any name is looked up:
//! later steps take time for each pair of some of them.

use super::{MAX_ROWS, MAX_TRIGGERS};
use crate::machine::definition::{Definition, StateDef};
use crate::machine::problem::{Location, Problem, Problems};
use crate::machine::set::MAX_MEMBERS;

impl Definition {
    /// Refuses a machine that is too large, without any further check.
    pub(crate) fn check_sizes(&self) -> Result<(), Problems> {
        // A table of 5,001 states took 73 s to be refused when names were looked up first.
        let mut list = Vec::new();
        let mut too_many = |place: Location, count: usize, what: &str, most: usize| {
            let message = format!("{count} {what}; at most {most} can be");
            list.push(Problem { place, message });
        };
        let (count, beyond) = states(&self.states);
        if let Some(place) = beyond {
            too_many(place, count, "states", MAX_MEMBERS);
        }
        if let Some(row) = self.rows.get(MAX_ROWS) {
            too_many(row.place, self.rows.len(), "rows", MAX_ROWS);
        }
        if let Some(name) = self.triggers.get(MAX_TRIGGERS) {
            too_many(name.place, self.triggers.len(), "triggers", MAX_TRIGGERS);
        }
        if list.is_empty() {
            return Ok(());
        }
        Err(Problems::new(&self.file, list))
    }
}

/// The number of states on all levels, and the place of the first beyond the limit.
fn states(states: &[StateDef]) -> (usize, Option<Location>) {
    // An explicit stack and not recursion: this runs before the depth is checked.
    let mut open: Vec<&StateDef> = states.iter().rev().collect();
    let (mut count, mut beyond) = (0, None);
    while let Some(state) = open.pop() {
        if count == MAX_MEMBERS {
            beyond = Some(state.name.place);
        }
        count += 1;
        open.extend(state.children.iter().rev());
    }
    (count, beyond)
}
