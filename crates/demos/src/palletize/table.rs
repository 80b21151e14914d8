//! The rows of the file, asked and told about.

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::machine::{
    Actions, CallbackId, Event, Fault, GuardId, Happening, Machine, StateId, Table, Vocabulary,
};
use behavior::{Graph, NodeStatus};

use robocell_skills::{Named, named};
use robocell_task::output::Output;

named! {
    /// States of the job; the file has to have them.
    pub(super) enum State {
        /// Nothing at hand.
        Idle = "idle",
        /// Taking a bin.
        Picking = "picking",
        /// Turning one over.
        Flipping = "flipping",
        /// Setting one down.
        Placing = "placing",
        /// All are placed.
        Done = "done",
    }
}

named! {
    /// What the policy fires.
    pub(super) enum Trigger {
        /// There is a bin to take.
        GoPick = "go_pick",
        /// It is on the cup.
        PickDone = "pick_done",
        /// It lies in the jig.
        FlipDone = "flip_done",
        /// It was let go on the pallet.
        PlaceDone = "place_done",
        /// It is not on the cup any more, or could not be gripped.
        Lost = "lost",
        /// All are placed, and nothing is at hand.
        AllPlaced = "all_placed",
    }
}

named! {
    /// What rows may ask.
    pub(super) enum Guard {
        /// The bin on the cup lies upside down.
        NeedsFlip = "needs_flip",
        /// As many bins stand in their places as shall.
        CompletesStack = "placement_completes_stack",
    }
}

/// Names a file may use.
pub(super) fn vocabulary() -> Vocabulary<'static> {
    Vocabulary {
        triggers: Trigger::NAMES,
        guards: Guard::NAMES,
        ..Vocabulary::default()
    }
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
        let guard = u16::try_from(guard.index()).ok().and_then(Guard::at);
        match guard {
            Some(Guard::NeedsFlip) => self.needs_flip,
            Some(Guard::CompletesStack) => self.complete,
            None => false,
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
        let name = self.machine.state_name();
        let known = State::ALL.iter().find(|state| state.name() == name);
        known.copied().unwrap_or(State::Idle)
    }

    /// Its name.
    pub(super) fn name(&self) -> &str {
        self.machine.state_name()
    }

    /// Fires `trigger`, tells what came of it, and answers whether a row was
    /// taken.
    pub(super) fn fire(&mut self, trigger: Trigger, mut facts: Facts, out: &mut Output) -> bool {
        let name = trigger.name();
        let Some(id) = self.machine.table().trigger(name) else {
            return false;
        };
        let before = self.machine.state();
        self.machine.clear_trace();
        let taken = match self.machine.trigger(id, &mut facts) {
            Ok(fired) => fired.taken,
            Err(error) => {
                out.event(TraceEvent::Fault, format_args!("[fault] {error}"));
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
        let name = state.name();
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
