//! The names of the machine's file, and their meaning in this job.

use behavior::machine::{Actions, CallbackId, Event, Fault, GuardId, Vocabulary};
use robocell_skills::{Named, named};

named! {
    /// States of the job; the file has to have them.
    pub(super) enum State {
        /// Nothing in progress.
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
    /// The triggers that the policy fires.
    pub(super) enum Trigger {
        /// A bin can be picked.
        GoPick = "go_pick",
        /// The bin is on the cup.
        PickDone = "pick_done",
        /// The bin is in the jig.
        FlipDone = "flip_done",
        /// The bin was released on the pallet.
        PlaceDone = "place_done",
        /// The bin is no longer on the cup, or could not be gripped.
        Lost = "lost",
        /// All bins are placed, and nothing is in progress.
        AllPlaced = "all_placed",
    }
}

named! {
    /// The guards that rows may use.
    pub(super) enum Guard {
        /// The bin on the cup is upside down.
        NeedsFlip = "needs_flip",
        /// All bins are in their places.
        CompletesStack = "placement_completes_stack",
    }
}

/// The names that a file may use.
pub(super) fn vocabulary() -> Vocabulary<'static> {
    Vocabulary {
        triggers: Trigger::NAMES,
        guards: Guard::NAMES,
        ..Vocabulary::default()
    }
}

/// The facts from which guards are answered.
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
