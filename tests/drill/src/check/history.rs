//! What states said, for the comparison with the state that a new physics resumes from.

use std::collections::VecDeque;

use ipc_types::WorldState;

/// States that a successor of physics may resume from.
const KEPT: usize = 2100;

/// Removes the newest entries of `all`, as far as they have not happened any more.
pub(super) fn undo<T>(all: &mut VecDeque<T>, is_undone: impl Fn(&T) -> bool) {
    while all.back().is_some_and(&is_undone) {
        all.pop_back();
    }
}

/// A value of each state.
#[derive(Default)]
pub(super) struct History {
    /// Tick, number of the reset of the scene, and value; the newest last.
    states: VecDeque<(u64, u32, u64)>,
}

impl History {
    /// Adds the value of `state`. True if it is the first of a physics, and an earlier physics had
    /// another one at that tick.
    pub(super) fn differs(&mut self, is_first: bool, state: &WorldState, value: u64) -> bool {
        // A request to reset the scene may have been obeyed again.
        let (tick, reset) = (state.header.tick, state.panel.scene_reset);
        let is_same = |of: &&(u64, u32, u64)| (of.0, of.1) == (tick, reset);
        let old = is_first.then(|| self.states.iter().find(is_same)).flatten();
        let differs = old.is_some_and(|(.., old)| *old != value);
        // Physics went back: later states are of an abandoned timeline.
        undo(&mut self.states, |(of, ..)| *of >= tick);
        self.states.push_back((tick, reset, value));
        if self.states.len() > KEPT {
            self.states.pop_front();
        }
        differs
    }
}
