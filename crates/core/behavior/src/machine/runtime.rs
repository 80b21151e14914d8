//! A running machine: a shared table and a small plain state.
//!
//! What a change must not break:
//! - a fault never leaves the machine between two states: up to the last exit callback it
//!   stays in the source, after that it is in the destination. `transitions` stays in the
//!   source with its exit callbacks done;
//! - a call is bounded: at most [`MAX_EVENTS`] triggers, and no memory is allocated, since
//!   it runs within a decision;
//! - guards are evaluated at most once per trigger (`memo`);
//! - the whole state is in the sets of [`Machine`]: the queue is empty between two calls, so
//!   it need not be saved.

use std::sync::Arc;

use super::actions::{Actions, Event, Fault, Queue};
use super::definition::Final;
use super::guards::{Memo, holds};
use super::ids::{RowId, StateId, TriggerId};
use super::set::SmallSet;
use super::table::{Row, Span, Table};
use super::trace::{Happening, Trace};
use crate::status::{NodeStatus, Status};

/// Largest number of triggers handled in one call: the fired one and those posted since.
// Callbacks that post to each other would never return.
pub const MAX_EVENTS: u16 = 64;

/// The result of a trigger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fired {
    /// Whether the fired trigger took a row, including internal ones.
    pub taken: bool,
    /// How many triggers were handled: this one and those posted meanwhile.
    pub handled: u16,
    /// The last row that the fired trigger took; in parallel regions there may be several.
    pub row: Option<RowId>,
}

/// Why a trigger was not handled. Waiting triggers are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TriggerError {
    /// No active state has a row for it, and the machine does not ignore that.
    #[error(
        "trigger {trigger:?} has no row in the active states; add one or set ignore_invalid_triggers"
    )]
    Invalid {
        /// The trigger.
        trigger: TriggerId,
    },
    /// A callback failed.
    #[error("a callback of trigger {trigger:?} failed: {fault}")]
    Failed {
        /// The trigger.
        trigger: TriggerId,
        /// The error of the callback.
        fault: Fault,
    },
    /// Callbacks kept posting triggers.
    #[error("more than {MAX_EVENTS} triggers in one call; callbacks post triggers in a circle")]
    Endless,
}

/// A machine: one for each controlled device; tables are shared.
#[derive(Clone, Debug)]
pub struct Machine {
    pub(super) table: Arc<Table>,
    /// Ranks of active states.
    pub(super) active: SmallSet,
    /// Ranks of states whose sub-behaviour has started and not finished.
    pub(super) running: SmallSet,
    /// Ranks of states whose sub-behaviour has finished.
    pub(super) finished: SmallSet,
    /// Ranks of states that were left while their sub-behaviour is stopping.
    pub(super) halting: SmallSet,
    pub(super) queue: Queue,
    memo: Memo,
    pub(super) trace: Trace<Happening>,
}

impl Machine {
    /// A machine in its initial state. Enter callbacks of that state are not
    /// run, as no state was entered.
    pub fn new(table: Arc<Table>) -> Self {
        let mut machine = Self {
            active: SmallSet::default(),
            running: SmallSet::default(),
            finished: SmallSet::default(),
            halting: SmallSet::default(),
            queue: Queue::EMPTY,
            memo: Memo::default(),
            trace: Trace::new(),
            table,
        };
        machine.set_state(machine.table.initial);
        machine
    }

    /// Its table.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Sets the state, without guards and callbacks. Sub-behaviours are
    /// not stopped, only their status is cleared.
    pub fn set_state(&mut self, state: StateId) {
        let none = SmallSet::default();
        self.active = self.table.configuration(state, &none);
        self.running = none;
        self.finished = none;
        self.halting = none;
    }

    /// Whether `state` is active: an innermost active state or one that contains it.
    pub fn is_active(&self, state: StateId) -> bool {
        let found = self.table.get(state);
        found.is_some_and(|it| self.active.contains(it.rank))
    }

    /// Innermost active states, in the order of the file. One, unless regions
    /// are parallel.
    pub fn active(&self) -> impl Iterator<Item = StateId> {
        let states = self.table.states.iter().enumerate();
        states
            .filter(|(_, it)| {
                // An innermost one has no other active state in its subtree.
                self.active.contains(it.rank) && self.active.intersection(&it.subtree).len() == 1
            })
            .map(|(at, _)| StateId::of(at))
    }

    /// The first innermost active state.
    pub fn state(&self) -> StateId {
        self.active().next().unwrap_or(self.table.initial)
    }

    /// Its full name.
    pub fn state_name(&self) -> &str {
        self.table.state_name(self.state())
    }

    /// Success or failure in a final state (in all regions of a parallel one;
    /// one failure is a failure of all), running otherwise.
    pub fn status(&self) -> Status {
        let mut failed = false;
        for state in self.active() {
            let end = self.table.get(state).map(|it| it.end);
            match end {
                Some(Final::Failure) => failed = true,
                Some(Final::Success) => {}
                Some(Final::No) | None => return Status::Running,
            }
        }
        if failed {
            Status::Failure
        } else {
            Status::Success
        }
    }

    /// The status of each state, in the order of [`Machine::describe`].
    pub fn statuses(&self) -> impl Iterator<Item = NodeStatus> {
        self.table
            .states
            .iter()
            .map(|it| match (self.active.contains(it.rank), it.end) {
                (false, _) if self.halting.contains(it.rank) => NodeStatus::Halting,
                (false, _) => NodeStatus::Invalid,
                (true, Final::No) => NodeStatus::Running,
                (true, Final::Success) => NodeStatus::Success,
                (true, Final::Failure) => NodeStatus::Failure,
            })
    }

    /// The events since [`Machine::clear_trace`], oldest first.
    pub fn trace(&self) -> &[Happening] {
        self.trace.kept()
    }

    /// Number of events that were not kept.
    pub fn lost_happenings(&self) -> u32 {
        self.trace.lost()
    }

    /// Clears the events.
    pub fn clear_trace(&mut self) {
        self.trace.clear();
    }

    /// Handles `trigger`, then those that its callbacks post, in their order.
    ///
    /// The order of callbacks: the machine's `prepare_event`; for each row of
    /// the active states, innermost first, `prepare` and the guards; for the
    /// first whose guards hold, `before_state_change`, `before`, exit of what is
    /// left (innermost first), enter of what is entered (outermost first),
    /// `after`, `after_state_change`; at last, always, `finalize_event`. In
    /// parallel regions each region may take a row.
    ///
    /// # Errors
    /// A trigger without a row, a callback that failed, or endless triggers.
    /// A fault before or while the source is left leaves the machine in the
    /// source, with the exit callbacks that ran not undone; a fault while the
    /// destination is entered, or later, leaves it in the destination. A fault
    /// in `finalize_event` is traced, and changes nothing.
    pub fn trigger(
        &mut self,
        trigger: TriggerId,
        actions: &mut impl Actions,
    ) -> Result<Fired, TriggerError> {
        // Nothing of an earlier call may wait here.
        self.queue.clear();
        let mut fired = self.handle(trigger, actions)?;
        // In the order in which they were posted, each as a separate trigger.
        while let Some(next) = self.queue.pop() {
            if fired.handled >= MAX_EVENTS {
                self.queue.clear();
                return Err(TriggerError::Endless);
            }
            self.handle(next, actions)?;
            fired.handled += 1;
        }
        Ok(fired)
    }

    fn handle(
        &mut self,
        trigger: TriggerId,
        actions: &mut impl Actions,
    ) -> Result<Fired, TriggerError> {
        // A new trigger evaluates its guards again.
        self.memo = Memo::default();
        let mut step = Step::new(trigger);
        let result = self.process(&mut step, actions);
        // `finalize_event` belongs to no row.
        step.row = None;
        let finalize = self.table.common.finalize_event;
        // Also after a fault, so that it can release what `prepare_event` took. Its own fault
        // is traced only: the change was made, and reporting a failure would deny it.
        if self.calls(finalize, &step, actions).is_err() {
            self.trace.add(Happening::Failed(trigger));
        }
        match result {
            Ok(true) => Ok(Fired {
                taken: step.taken.is_some(),
                handled: 1,
                row: step.taken,
            }),
            Ok(false) => self.invalid(trigger),
            Err(fault) => {
                self.trace.add(Happening::Failed(trigger));
                // Posted triggers expected the change that did not happen.
                self.queue.clear();
                Err(TriggerError::Failed { trigger, fault })
            }
        }
    }

    fn invalid(&mut self, trigger: TriggerId) -> Result<Fired, TriggerError> {
        self.trace.add(Happening::Invalid(trigger));
        if self.table.ignore_invalid {
            return Ok(Fired {
                taken: false,
                handled: 1,
                row: None,
            });
        }
        self.queue.clear();
        Err(TriggerError::Invalid { trigger })
    }

    /// Tries the rows of the active states; returns whether there was any.
    fn process(&mut self, step: &mut Step, actions: &mut impl Actions) -> Result<bool, Fault> {
        let mut valid = false;
        let mut done = SmallSet::default();
        // A separate reference: callbacks borrow the machine while rows are read.
        let table = Arc::clone(&self.table);
        for rank in self.active.iter() {
            // States that another region's row has left or entered are not tried any more.
            if done.contains(rank) || !self.active.contains(rank) {
                continue;
            }
            let rows = table.rows_of(step.trigger, rank);
            if rows.is_empty() {
                continue;
            }
            // Once per trigger, and not for a trigger that no state knows.
            if !valid {
                valid = true;
                self.calls(table.common.prepare_event, step, actions)?;
            }
            for row in rows {
                if let Some(entered) = self.try_row(&table, row, step, actions)? {
                    let path = table.at(rank).map(|it| it.path).unwrap_or_default();
                    // The states around have a chance only if none inside took the trigger.
                    done = done.union(&path).union(&entered);
                    break;
                }
            }
        }
        // There were rows, but no guards held: not the same as an unknown trigger.
        if valid && step.taken.is_none() {
            self.trace.add(Happening::Blocked(step.trigger));
        }
        Ok(valid)
    }

    /// Tries a row; returns the entered states if it was taken.
    fn try_row(
        &mut self,
        table: &Table,
        row: &Row,
        step: &mut Step,
        actions: &mut impl Actions,
    ) -> Result<Option<SmallSet>, Fault> {
        step.row = Some((row.id, row.source, row.dest));
        // Before the guards, as in `transitions`: it may compute what they read.
        self.calls(row.prepare, step, actions)?;
        let (memo, trace) = (&mut self.memo, &mut self.trace);
        if !holds(table, row, memo, actions, &mut |it| trace.add(it)) {
            return Ok(None);
        }
        self.calls(table.common.before_state_change, step, actions)?;
        self.calls(row.before, step, actions)?;
        // From here on the row counts as taken, also if a callback fails.
        step.taken = Some(row.id);
        let transition = Happening::Transition {
            row: row.id,
            trigger: step.trigger,
            source: row.source,
            dest: row.dest,
        };
        let entered = if let Some(dest) = row.dest {
            self.change(table, dest, transition, step, actions)?
        } else {
            // Internal: no state is left or entered, only callbacks run.
            self.trace.add(transition);
            SmallSet::default()
        };
        self.calls(row.after, step, actions)?;
        self.calls(table.common.after_state_change, step, actions)?;
        Ok(Some(entered))
    }

    /// Runs callbacks up to the first that fails.
    pub(super) fn calls(
        &mut self,
        calls: Span,
        step: &Step,
        actions: &mut impl Actions,
    ) -> Result<(), Fault> {
        for call in calls.of(&self.table.calls) {
            let mut event = Event {
                trigger: step.trigger,
                row: step.row.map(|(row, ..)| row),
                source: step.row.map(|(_, source, _)| source),
                dest: step.row.and_then(|(.., dest)| dest),
                queue: &mut self.queue,
            };
            actions.call(*call, &mut event)?;
        }
        Ok(())
    }
}

/// The state of the handling of one trigger.
#[derive(Debug)]
pub(super) struct Step {
    pub(super) trigger: TriggerId,
    row: Option<(RowId, StateId, Option<StateId>)>,
    taken: Option<RowId>,
}

impl Step {
    fn new(trigger: TriggerId) -> Self {
        Self {
            trigger,
            row: None,
            taken: None,
        }
    }
}
