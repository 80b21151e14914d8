//! A machine in a policy, whose changes are written to the trace.

use std::sync::Arc;

use behavior::machine::{Actions, Happening, Machine, StateId, Table};
use behavior::{Graph, NodeStatus};
use robocell_task::{Output, TraceEvent};

/// Reports that a call had more changes than its trace has room for.
pub(crate) fn lost(happenings: u32, out: &mut Output) {
    if happenings > 0 {
        let room = behavior::machine::TRACE_CAPACITY;
        out.log(format_args!(
            "[trace] {happenings} changes and guards are not shown: {room} are kept of one call"
        ));
    }
}

/// A machine, with the table that it starts from after a reset.
#[derive(Clone, Debug)]
pub struct MachineRun {
    table: Arc<Table>,
    pub(crate) machine: Machine,
}

impl MachineRun {
    /// A machine in its first state.
    pub fn new(table: Arc<Table>) -> Self {
        Self {
            machine: Machine::new(Arc::clone(&table)),
            table,
        }
    }

    /// Resets the machine to its first state.
    pub fn reset(&mut self) {
        *self = Self::new(Arc::clone(&self.table));
    }

    /// Name of its state.
    pub fn state(&self) -> &str {
        self.machine.state_name()
    }

    /// Fires a trigger by its name; returns whether a row was taken.
    pub fn fire(&mut self, trigger: &str, actions: &mut impl Actions, out: &mut Output) -> bool {
        let Some(id) = self.table.trigger(trigger) else {
            return false;
        };
        self.machine.clear_trace();
        let fired = self.machine.trigger(id, actions);
        self.tell(out);
        match fired {
            Ok(fired) => fired.taken,
            Err(error) => {
                out.event(TraceEvent::Fault, format_args!("[fault] {error}"));
                false
            }
        }
    }

    /// Puts the machine into a state without a row, where the observation allows no other.
    pub fn set(&mut self, state: &str, why: &str, out: &mut Output) {
        let before = self.machine.state();
        if let Some(id) = self.table.state(state).filter(|id| *id != before) {
            self.machine.set_state(id);
            self.tell_change(before, id, why, out);
        }
    }

    /// Traces the evaluated guards, and each transition with its trigger.
    pub(crate) fn tell(&self, out: &mut Output) {
        for happening in self.machine.trace() {
            match *happening {
                Happening::Guard { guard, value } => {
                    let node = (0, self.machine.state().index());
                    out.guard(node, self.table.guard_name(guard), value);
                }
                Happening::Transition {
                    trigger,
                    source,
                    dest: Some(dest),
                    ..
                } => self.tell_change(source, dest, self.table.trigger_name(trigger), out),
                _ => {}
            }
        }
        lost(self.machine.lost_happenings(), out);
    }

    fn tell_change(&self, from: StateId, to: StateId, why: &str, out: &mut Output) {
        let node = |state: StateId| (0, state.index());
        out.status(node(from), NodeStatus::Running, NodeStatus::Invalid, why);
        // Traced as end and start of a state, so a picture of the graph follows without a full
        // status.
        let mut statuses = self.machine.statuses();
        let entered = statuses.nth(to.index()).unwrap_or(NodeStatus::Running);
        out.status(node(to), NodeStatus::Invalid, entered, why);
        let (from, to) = (self.table.state_name(from), self.table.state_name(to));
        out.transition(format_args!("{from} -> {to} ({why})"));
    }

    /// Its graph.
    pub fn describe(&self) -> Graph {
        self.machine.describe()
    }

    /// Appends the statuses of its states.
    pub fn statuses(&self, out: &mut Vec<NodeStatus>) {
        out.extend(self.machine.statuses());
    }

    /// Its state, for the checkpoint.
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.machine.record_bytes());
        self.machine.save(&mut bytes);
        bytes
    }

    /// Restores the bytes of [`Self::save`].
    ///
    /// # Errors
    /// Returns an error for a checkpoint that is damaged or of another machine; nothing has
    /// changed then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let restored = self.machine.restore(bytes);
        restored.map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_trace_has_no_room_for_is_reported_with_its_number() {
        let (mut out, mut lines) = (Output::default(), Vec::new());
        lost(0, &mut out);
        lost(7, &mut out);
        out.finish(0, &mut ipc_types::Wire::zeroed(), &mut lines);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].text.as_str().contains("7 changes and guards"));
    }
}
