//! What the job remembers between two decisions, beside the state of its matrix.

use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use robocell_skills::Path;
use robocell_skills::suction::GripMemory;
use robocell_task::time::PolicyTime;

/// Part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent facts, each true or not"
)]
pub(super) struct Memory {
    pub(super) motion: Path,
    pub(super) grip: GripMemory,
    /// What the gripper is told.
    suction: Suction,
    /// No goal counts as reached before this.
    pub(super) wait_until: PolicyTime,
    /// An attachment nobody has handled yet.
    pub(super) attached: bool,
    /// The cup stood still at the surface for a while.
    pub(super) settled: bool,
    /// Suction was tried at this place before.
    pub(super) tried: bool,
    /// When the state was entered.
    pub(super) since: PolicyTime,
    /// Since when the bin cannot be picked up.
    pub(super) stuck_since: Option<PolicyTime>,
    /// The task was reset: what is in the hand is let go first.
    pub(super) let_go: bool,
    /// A grip broke since the job began.
    pub(super) broke: bool,
    /// A bin that hangs upside down was carried aside.
    pub(super) aside: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Suction {
    #[default]
    Keep,
    Off,
    On,
}

impl Memory {
    pub(super) fn new() -> Self {
        Self {
            motion: Path::new(),
            ..Self::default()
        }
    }

    /// What the gripper is told.
    pub(super) fn gripper(&self) -> GripperGoal {
        match self.suction {
            Suction::Keep => GripperGoal::Keep,
            Suction::Off => GripperGoal::Open,
            Suction::On => GripperGoal::Close,
        }
    }

    /// Tells the gripper to switch.
    pub(super) fn switch(&mut self, on: bool) {
        self.suction = if on { Suction::On } else { Suction::Off };
    }

    /// Wants the goal reached once more, `pause` from now on.
    pub(super) fn again_after(&mut self, pause: PolicyTime, now: PolicyTime) {
        self.wait_until = PolicyTime::from_ticks(now.ticks() + pause.ticks());
        self.motion.again();
    }
}
