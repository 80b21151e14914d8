//! All the job remembers between two decisions.

use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use robocell_skills::suction::GripMemory;
use robocell_skills::{KeptPose, Path};
use robocell_task::job::MOST_COUNTED;
use robocell_task::time::PolicyTime;

/// Plain data, for the checkpoint. The matrix's state stands beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// Where the arm goes.
    pub(super) motion: Path,
    /// The gripper as last seen.
    pub(super) grip: GripMemory,
    /// Suction is to be on.
    pub(super) closed: bool,
    /// Since when suction was told to attach something, or to let go.
    pub(super) acting: Option<PolicyTime>,
    /// The bin under way, by its index in the cell file.
    pub(super) bin: Option<usize>,
    /// It has to be turned over before it can be placed.
    pub(super) turning: bool,
    /// The bin in the frame of the cup, as it was gripped.
    pub(super) in_hand: Option<KeptPose>,
    /// Where it goes: column in the order of filling, level.
    pub(super) slot: Option<(usize, usize)>,
    /// It was let go over its slot and not looked at since.
    pub(super) set_down: Option<usize>,
    /// Since when the state is what it is.
    pub(super) since: PolicyTime,
    /// States in a row that lasted too long.
    pub(super) stuck: u32,
    pub(super) supply: SupplyMemory,
}

/// What was asked of the conveyor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SupplyMemory {
    /// When the next bin is asked for.
    pub(super) next_at: Option<PolicyTime>,
    /// When one was asked for last.
    pub(super) asked_at: Option<PolicyTime>,
    /// Picks from the belt so far; each has its own random delay.
    pub(super) picks: u64,
    /// Since when nothing is left to pick while bins are missing.
    pub(super) missing_since: Option<PolicyTime>,
}

impl Memory {
    pub(super) fn new() -> Self {
        Self {
            motion: Path::new(),
            grip: GripMemory::default(),
            closed: false,
            acting: None,
            bin: None,
            turning: false,
            in_hand: None,
            slot: None,
            set_down: None,
            since: PolicyTime::default(),
            stuck: 0,
            supply: SupplyMemory::default(),
        }
    }

    /// What the gripper is told.
    pub(super) fn gripper(&self) -> GripperGoal {
        if self.closed {
            GripperGoal::Close
        } else {
            GripperGoal::Open
        }
    }

    /// It was told to let go, and nobody knows yet whether it did.
    pub(super) fn opening(&self) -> bool {
        !self.closed && self.acting.is_some()
    }

    /// Nothing is under way any more.
    pub(super) fn forget_bin(&mut self) {
        self.bin = None;
        self.turning = false;
        self.in_hand = None;
        self.slot = None;
        self.acting = None;
    }

    /// Whether a restored record can belong to a cell with that many objects.
    pub(super) fn is_sound(&self, objects: usize) -> bool {
        let known = |object: &Option<usize>| object.is_none_or(|index| index < objects);
        let held = self.in_hand.is_none_or(|pose| pose.is_sound());
        let counted = self.stuck < MOST_COUNTED && self.supply.picks < u64::from(MOST_COUNTED);
        self.motion.is_sound() && held && counted && known(&self.bin) && known(&self.set_down)
    }
}
