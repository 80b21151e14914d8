//! What the policy remembers from decision to decision.

use ipc_types::validate::MAX_JOINT_POSITION;
use serde::{Deserialize, Serialize};

use super::JOINTS;
use super::setup::PalletizeSetup;
use super::steps::{Sequence, Way};
use robocell_skills::KeptPose;
use robocell_skills::path::MAX_APPROACH_M;
use robocell_skills::pose::within;
use robocell_task::time::PolicyTime;

/// Where the arm is sent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Motion {
    /// The tool's target.
    pub(super) target: KeptPose,
    /// Joint positions to lean to, or to reach (rad).
    pub(super) posture: [f64; JOINTS],
    /// The joints are sent there, not the tool: the arm ends in the same of the
    /// postures in which the tool is at the target.
    pub(super) by_joints: bool,
    /// Direction of the approach times its length (m).
    pub(super) approach: [f64; 3],
    /// Width of its corridor (m).
    pub(super) std_dev: f64,
}

/// The bin at hand, and how far it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Work {
    /// Its place in the setup.
    pub(super) bin: usize,
    /// What is done with it.
    pub(super) kind: WorkKind,
    /// It came from the belt, not from the jig.
    pub(super) from_belt: bool,
    /// Which substep.
    pub(super) step: usize,
    /// When that began.
    pub(super) began: PolicyTime,
    /// Refusals of the gripper when that began.
    pub(super) refusals: u32,
    /// What the target was, and the tool's pose, when that began.
    pub(super) base: KeptPose,
    /// Joint positions when that began (rad).
    pub(super) joints: [f64; JOINTS],
    /// Where on the pallet it goes.
    pub(super) slot: Option<usize>,
    /// How far it has crept, x and y (m).
    pub(super) creep: [f64; 2],
}

/// See [`Sequence`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum WorkKind {
    /// Take a bin that opens upwards.
    Pick,
    /// Take one that lies upside down.
    PickFlipped,
    /// Bring one to the jig.
    Flip,
    /// Set one down.
    Place,
    /// Set one down that comes from the belt.
    PlaceFromBelt,
    /// Set one down that did not come to its place: over the rest pose.
    PlaceFromHome,
}

impl WorkKind {
    /// The substeps.
    pub(super) fn sequence(self) -> Sequence {
        match self {
            Self::Pick => Sequence::Pick { flipped: false },
            Self::PickFlipped => Sequence::Pick { flipped: true },
            Self::Flip => Sequence::Flip,
            Self::Place => Sequence::Place { way: Way::Straight },
            Self::PlaceFromBelt => Sequence::Place { way: Way::Around },
            Self::PlaceFromHome => Sequence::Place { way: Way::Home },
        }
    }
}

/// All but the state of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The bin at hand; none in idle and done.
    pub(super) work: Option<Work>,
    /// Where the arm was sent last.
    pub(super) motion: Option<Motion>,
    /// When a bin was last asked for.
    pub(super) asked: Option<PolicyTime>,
}

impl Memory {
    /// Whether a restored memory can belong to that job.
    pub(super) fn is_sound(&self, setup: &PalletizeSetup) -> bool {
        let work = self.work.is_none_or(|work| work.is_sound(setup));
        work && self.motion.is_none_or(|motion| motion.is_sound())
    }
}

impl Work {
    fn is_sound(&self, setup: &PalletizeSetup) -> bool {
        self.bin < setup.bins.len()
            && self.kind.sequence().step(self.step).is_some()
            && self.slot.is_none_or(|slot| slot < setup.slots.len())
            && self.base.is_sound()
            && within(&self.joints, MAX_JOINT_POSITION)
            && within(&self.creep, setup.numbers.place.creep_m)
    }
}

impl Motion {
    fn is_sound(&self) -> bool {
        self.target.is_sound()
            && within(&self.posture, MAX_JOINT_POSITION)
            && within(&self.approach, MAX_APPROACH_M)
            && within(&[self.std_dev], MAX_APPROACH_M)
    }
}
