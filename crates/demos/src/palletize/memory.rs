//! What the policy remembers from decision to decision.

use ipc_types::MAX_JOINTS;
use ipc_types::validate::MAX_JOINT_POSITION;
use robocell_skills::pose::within;
use robocell_skills::{KeptPose, Path};
use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use super::setup::PalletizeSetup;

/// The bin at hand, and how far it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Work {
    /// Its index in the setup.
    pub(super) bin: usize,
    /// What is done with it.
    pub(super) kind: WorkKind,
    /// It came from the belt, not from the jig.
    pub(super) from_belt: bool,
    /// Which step.
    pub(super) step: usize,
    /// When that began.
    pub(super) began: PolicyTime,
    /// Refusals of the gripper when that began.
    pub(super) refusals: u32,
    /// What the target was, and the tool's pose, when that began.
    pub(super) base: KeptPose,
    /// Joint positions when that began (rad).
    pub(super) joints: [f64; MAX_JOINTS],
    /// Where on the pallet it goes.
    pub(super) slot: Option<usize>,
    /// How far it has crept, x and y (m).
    pub(super) creep: [f64; 2],
}

/// Which sequence of steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum WorkKind {
    /// Take a bin that opens upwards.
    Pick,
    /// Take one that is upside down.
    PickFlipped,
    /// Bring one to the jig.
    Flip,
    /// Set one down.
    Place,
    /// Set one down that comes from the belt.
    PlaceFromBelt,
    /// Set one down that was not brought to its place: over the rest pose.
    PlaceFromHome,
}

impl WorkKind {
    /// All of them; the index is that of their sequence.
    pub(super) const ALL: [Self; 6] = [
        Self::Pick,
        Self::PickFlipped,
        Self::Flip,
        Self::Place,
        Self::PlaceFromBelt,
        Self::PlaceFromHome,
    ];

    /// Whether it takes a bin, and does not start with one on the cup.
    pub(super) fn picks(self) -> bool {
        matches!(self, Self::Pick | Self::PickFlipped)
    }
}

/// All but the state of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The bin at hand; none in idle and done.
    pub(super) work: Option<Work>,
    /// Where the arm was sent last: one waypoint.
    pub(super) path: Path,
    /// When a bin was last asked for.
    pub(super) asked: Option<PolicyTime>,
}

impl Memory {
    /// Whether a restored memory can belong to that job.
    pub(super) fn is_sound(&self, setup: &PalletizeSetup) -> bool {
        let sound = |work: Work| {
            work.bin < setup.bins.len()
                && setup.sequence(work.kind).step(work.step).is_some()
                && work.slot.is_none_or(|slot| slot < setup.slots.len())
                && work.base.is_sound()
                && within(&work.joints, MAX_JOINT_POSITION)
                && within(&work.creep, setup.task.creep_m)
        };
        self.path.is_sound() && self.work.is_none_or(sound)
    }
}
