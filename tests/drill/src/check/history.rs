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
    /// Tick, numbers of the requests that change the scene at once, and value; the newest last.
    states: VecDeque<(u64, [u32; 3], u64)>,
}

impl History {
    /// Adds the value of `state`. True if it is the first of a physics, and an earlier physics had
    /// another one at that tick.
    pub(super) fn differs(&mut self, is_first: bool, state: &WorldState, value: u64) -> bool {
        // Requests of later ticks are obeyed again in the first state.
        let (tick, panel) = (state.header.tick, &state.panel);
        let requests = [panel.scene_reset, panel.add_bin, panel.drop_parts];
        let is_same = |of: &&(u64, [u32; 3], u64)| (of.0, of.1) == (tick, requests);
        let old = is_first.then(|| self.states.iter().find(is_same)).flatten();
        let differs = old.is_some_and(|(.., old)| *old != value);
        // Physics went back: later states are of an abandoned timeline.
        undo(&mut self.states, |(of, ..)| *of >= tick);
        self.states.push_back((tick, requests, value));
        if self.states.len() > KEPT {
            self.states.pop_front();
        }
        differs
    }
}
