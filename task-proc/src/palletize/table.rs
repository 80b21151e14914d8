//! The rows of the file, asked and told about.

use std::sync::Arc;

use behavior::machine::{
    Actions, CallbackId, Event, Fault, GuardId, Happening, Machine, StateId, Table, Vocabulary,
};
use behavior::{Graph, NodeStatus};

use crate::output::Output;

/// States the file has to have.
pub(super) const STATES: [&str; 5] = ["idle", "picking", "flipping", "placing", "done"];
/// What the policy fires.
pub(super) const TRIGGERS: [&str; 6] = [
    "go_pick",
    "pick_done",
    "flip_done",
    "place_done",
    "lost",
    "all_placed",
];
/// What rows may ask.
pub(super) const GUARDS: [&str; 2] = ["needs_flip", "placement_completes_stack"];

/// Names a file may use.
pub(super) fn vocabulary() -> Vocabulary<'static> {
    Vocabulary {
        triggers: &TRIGGERS,
        guards: &GUARDS,
        ..Vocabulary::default()
    }
}

/// States of the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Nothing at hand.
    Idle,
    /// Taking a bin.
    Picking,
    /// Turning one over.
    Flipping,
    /// Setting one down.
    Placing,
    /// All are placed.
    Done,
}

/// Triggers, in the order of [`TRIGGERS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trigger {
    /// There is a bin to take.
    GoPick,
    /// It is on the cup.
    PickDone,
    /// It lies in the jig.
    FlipDone,
    /// It was let go on the pallet.
    PlaceDone,
    /// It is not on the cup any more, or could not be gripped.
    Lost,
    /// All are placed, and nothing is at hand.
    AllPlaced,
}

/// What guards are answered from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Facts {
    /// The bin on the cup lies upside down.
    pub(super) needs_flip: bool,
    /// As many bins stand in their places as shall.
    pub(super) complete: bool,
}

impl Actions for Facts {
    fn guard(&mut self, guard: GuardId) -> bool {
        match guard.index() {
            0 => self.needs_flip,
            _ => self.complete,
        }
    }

    fn call(&mut self, _callback: CallbackId, _event: &mut Event<'_>) -> Result<(), Fault> {
        Ok(())
    }
}

/// The machine.
pub(super) struct States {
    machine: Machine,
}

impl States {
    /// In its first state.
    pub(super) fn new(table: Arc<Table>) -> Self {
        Self {
            machine: Machine::new(table),
        }
    }

    /// The state; one the file has besides is as good as idle.
    pub(super) fn state(&self) -> State {
        match self.machine.state_name() {
            "picking" => State::Picking,
            "flipping" => State::Flipping,
            "placing" => State::Placing,
            "done" => State::Done,
            _ => State::Idle,
        }
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        self.machine.state_name()
    }

    /// Fires `trigger`, tells what came of it, and answers whether a row was
    /// taken.
    pub(super) fn fire(&mut self, trigger: Trigger, mut facts: Facts, out: &mut Output) -> bool {
        let name = TRIGGERS.get(trigger as usize).copied().unwrap_or_default();
        let Some(id) = self.machine.table().trigger(name) else {
            return false;
        };
        let before = self.machine.state();
        self.machine.clear_trace();
        let taken = match self.machine.trigger(id, &mut facts) {
            Ok(fired) => fired.taken,
            Err(error) => {
                out.log(format_args!("[fault] {error}"));
                false
            }
        };
        self.tell(before, name, out);
        taken
    }

    /// Puts the machine into a state without a row: what is seen leaves no
    /// other.
    pub(super) fn set(&mut self, state: State, why: &str, out: &mut Output) {
        let before = self.machine.state();
        let name = STATES.get(state as usize).copied().unwrap_or_default();
        let Some(id) = self.machine.table().state(name).filter(|id| *id != before) else {
            return;
        };
        self.machine.set_state(id);
        out.status(
            (0, before.index()),
            NodeStatus::Running,
            NodeStatus::Invalid,
            why,
        );
        out.status((0, id.index()), NodeStatus::Invalid, self.status(id), why);
        out.transition(format_args!("  -> {name}"));
    }

    fn tell(&self, before: StateId, trigger: &str, out: &mut Output) {
        for happening in self.machine.trace() {
            match *happening {
                Happening::Guard { guard, value } => {
                    let name = self.machine.table().guard_name(guard);
                    out.guard((0, before.index()), name, value);
                }
                Happening::Left(state) => out.status(
                    (0, state.index()),
                    NodeStatus::Running,
                    NodeStatus::Invalid,
                    trigger,
                ),
                Happening::Entered(state) => {
                    out.status(
                        (0, state.index()),
                        NodeStatus::Invalid,
                        self.status(state),
                        trigger,
                    );
                    let name = self.machine.table().state_name(state);
                    out.transition(format_args!("  -> {name}"));
                }
                _ => {}
            }
        }
    }

    fn status(&self, state: StateId) -> NodeStatus {
        let mut statuses = self.machine.statuses();
        statuses.nth(state.index()).unwrap_or(NodeStatus::Invalid)
    }

    /// The picture.
    pub(super) fn describe(&self) -> Graph {
        self.machine.describe()
    }

    /// Appends how its nodes stand.
    pub(super) fn statuses(&self, out: &mut Vec<NodeStatus>) {
        out.extend(self.machine.statuses());
    }

    /// Its state as bytes.
    pub(super) fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.machine.record_bytes());
        self.machine.save(&mut bytes);
        bytes
    }

    /// Takes it back; answers whether it could.
    pub(super) fn restore(&mut self, bytes: &[u8]) -> bool {
        self.machine.restore(bytes).is_ok()
    }

    /// Begins anew.
    pub(super) fn reset(&mut self, table: Arc<Table>) {
        self.machine = Machine::new(table);
    }
}
