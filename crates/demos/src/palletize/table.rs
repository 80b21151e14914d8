//! The names of the machine's file, and what they mean here.

use behavior::machine::{Actions, CallbackId, Event, Fault, GuardId, Vocabulary};
use robocell_skills::{Named, named};

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
        /// It is in the jig.
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
        /// The bin on the cup is upside down.
        NeedsFlip = "needs_flip",
        /// All bins are in their places.
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
    /// The bin on the cup is upside down.
    pub(super) needs_flip: bool,
    /// All bins are in their places.
    pub(super) complete: bool,
}

impl Actions for Facts {
    fn guard(&mut self, guard: GuardId) -> bool {
        match u16::try_from(guard.index()).ok().and_then(Guard::at) {
            Some(Guard::NeedsFlip) => self.needs_flip,
            Some(Guard::CompletesStack) => self.complete,
            None => false,
        }
    }

    fn call(&mut self, _callback: CallbackId, _event: &mut Event<'_>) -> Result<(), Fault> {
        Ok(())
    }
}
