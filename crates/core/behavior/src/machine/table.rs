//! A compiled machine: flat arrays, shared by all machines of one definition.

use super::definition::Final;
use super::ids::{BehaviorId, CallbackId, GuardId, RowId, StateId, TriggerId};
use super::set::SmallSet;

/// Part of a flat array.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Span {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl Span {
    pub(crate) fn of<T>(self, all: &[T]) -> &[T] {
        // Empty for a span out of range: indices come from the compiler, and a wrong one must
        // not end the task.
        all.get(self.start as usize..self.end as usize)
            .unwrap_or_default()
    }
}

/// A guard and its required result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Condition {
    pub(crate) guard: GuardId,
    pub(crate) expected: bool,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct During {
    pub(crate) run: BehaviorId,
    pub(crate) success: Option<TriggerId>,
    pub(crate) failure: Option<TriggerId>,
}

/// A state. Sets of states are sets of ranks: the deepest level first, within a
/// level the order of the file. In that order states are tried and left.
#[derive(Clone, Debug)]
pub(crate) struct State {
    /// Full name: those of its parents and its own, joined by dots.
    pub(crate) name: String,
    pub(crate) hash: u64,
    pub(crate) parent: Option<StateId>,
    pub(crate) rank: usize,
    pub(crate) depth: usize,
    pub(crate) enter: Span,
    pub(crate) exit: Span,
    pub(crate) end: Final,
    pub(crate) parallel: bool,
    pub(crate) has_children: bool,
    pub(crate) during: Option<During>,
    /// The state and all states inside of it.
    pub(crate) subtree: SmallSet,
    /// The states that become active when it is entered without naming a child.
    pub(crate) entry: SmallSet,
    /// The state and its parents.
    pub(crate) path: SmallSet,
}

/// A row for one source.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) id: RowId,
    pub(crate) trigger: TriggerId,
    pub(crate) source: StateId,
    pub(crate) dest: Option<StateId>,
    pub(crate) conditions: Span,
    pub(crate) prepare: Span,
    pub(crate) before: Span,
    pub(crate) after: Span,
}

/// Callbacks of the machine, not of one state or row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Common {
    pub(crate) prepare_event: Span,
    pub(crate) before_state_change: Span,
    pub(crate) after_state_change: Span,
    pub(crate) finalize_event: Span,
    pub(crate) on_final: Span,
}

/// A compiled machine. Shared by reference among the machines that run it.
#[derive(Clone, Debug)]
pub struct Table {
    pub(crate) name: String,
    pub(crate) states: Vec<State>,
    /// State of each rank.
    pub(crate) by_rank: Vec<StateId>,
    /// Ranks of each depth, outermost first.
    pub(crate) levels: Vec<SmallSet>,
    pub(crate) initial: StateId,
    pub(crate) triggers: Vec<String>,
    pub(crate) guards: Vec<String>,
    pub(crate) callbacks: Vec<String>,
    pub(crate) behaviors: Vec<String>,
    /// Sorted by trigger, then rank of the source, then order of declaration.
    pub(crate) rows: Vec<Row>,
    /// Rows of `trigger * states + rank`.
    pub(crate) index: Vec<Span>,
    pub(crate) conditions: Vec<Condition>,
    pub(crate) calls: Vec<CallbackId>,
    pub(crate) common: Common,
    /// Ranks of states with a sub-behaviour.
    pub(crate) during: SmallSet,
    pub(crate) ignore_invalid: bool,
    /// Lines of the declared rows, for messages; 0 if written in Rust.
    pub(crate) row_lines: Vec<u32>,
}

impl Table {
    /// Name of the machine.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of states; their ids are the smaller numbers.
    pub fn state_count(&self) -> usize {
        self.states.len()
    }

    /// The state with this full name.
    pub fn state(&self, name: &str) -> Option<StateId> {
        let found = self.states.iter().position(|state| state.name == name);
        found.map(StateId::of)
    }

    /// Full name of a state; empty for one of another machine.
    pub fn state_name(&self, state: StateId) -> &str {
        self.states.get(state.index()).map_or("", |it| &it.name)
    }

    /// The trigger with this name.
    pub fn trigger(&self, name: &str) -> Option<TriggerId> {
        let found = self.triggers.iter().position(|trigger| trigger == name);
        found.map(TriggerId::of)
    }

    /// Name of a trigger; empty for one of another machine.
    pub fn trigger_name(&self, trigger: TriggerId) -> &str {
        self.triggers.get(trigger.index()).map_or("", |it| it)
    }

    /// Name of a guard; empty for one of another vocabulary.
    pub fn guard_name(&self, guard: GuardId) -> &str {
        self.guards.get(guard.index()).map_or("", |it| it)
    }

    /// Name of a callback; empty for one of another vocabulary.
    pub fn callback_name(&self, callback: CallbackId) -> &str {
        self.callbacks.get(callback.index()).map_or("", |it| it)
    }

    /// Name of a sub-behaviour; empty for one of another vocabulary.
    pub fn behavior_name(&self, behavior: BehaviorId) -> &str {
        self.behaviors.get(behavior.index()).map_or("", |it| it)
    }

    /// Triggers that have a row in `state` itself, in order of their ids.
    pub fn triggers_of(&self, state: StateId) -> impl Iterator<Item = TriggerId> {
        let rank = self.states.get(state.index()).map(|state| state.rank);
        (0..self.triggers.len())
            .map(TriggerId::of)
            .filter(move |trigger| {
                rank.is_some_and(|rank| !self.rows_of(*trigger, rank).is_empty())
            })
    }

    pub(crate) fn rows_of(&self, trigger: TriggerId, rank: usize) -> &[Row] {
        let at = trigger.index() * self.states.len() + rank;
        self.index
            .get(at)
            .copied()
            .unwrap_or_default()
            .of(&self.rows)
    }

    pub(crate) fn at(&self, rank: usize) -> Option<&State> {
        self.states.get(self.by_rank.get(rank)?.index())
    }

    pub(crate) fn get(&self, state: StateId) -> Option<&State> {
        self.states.get(state.index())
    }

    /// The states that become active when `state` is entered while `kept` stays
    /// active: its parents, its initial children, and the other regions of
    /// every parallel parent that is entered with it.
    pub(crate) fn configuration(&self, state: StateId, kept: &SmallSet) -> SmallSet {
        let Some(it) = self.get(state) else {
            return SmallSet::default();
        };
        let mut all = it.path.union(&it.entry);
        let mut inner = it;
        while let Some(parent) = inner.parent.and_then(|parent| self.get(parent)) {
            // A parallel parent that is active already has its other regions active.
            if parent.parallel && !kept.contains(parent.rank) {
                all = all.union(&parent.entry.difference(&inner.subtree));
            }
            inner = parent;
        }
        all.difference(kept)
    }
}
