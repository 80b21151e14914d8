//! The memory of the policy, from decision to decision.

use ipc_types::MAX_JOINTS;
use ipc_types::validate::MAX_JOINT_POSITION;
use robocell_skills::pose::within;
use robocell_skills::{KeptPose, Path};
use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use super::setup::PalletizeSetup;
use super::work_kind::WorkKind;

/// The bin in progress, and its step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Work {
    /// Its index in the setup.
    pub(super) bin: usize,
    /// The work on it.
    pub(super) kind: WorkKind,
    /// Whether it was picked from the belt and not from the jig.
    pub(super) from_belt: bool,
    /// Index of the step.
    pub(super) step: usize,
    /// Start of the step.
    pub(super) began: PolicyTime,
    /// Refusals of the gripper at the start of the step.
    pub(super) refusals: u32,
    /// Target of the step before, or the tool's pose, at the start of the step.
    pub(super) base: KeptPose,
    /// Joint positions at the start of the step (rad).
    pub(super) joints: [f64; MAX_JOINTS],
    /// Its place on the pallet; one that shall be set down without a place waits for one.
    pub(super) slot: Option<usize>,
    /// How far the target has crept, x and y (m).
    pub(super) creep: [f64; 2],
}

impl Work {
    /// Whether the bin shall be set down and has no place.
    pub(super) fn waits(&self) -> bool {
        self.kind.places() && self.slot.is_none()
    }
}

/// The memory except for the state of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The bin in progress; `None` in idle and done.
    pub(super) work: Option<Work>,
    /// The last goal of the arm: one waypoint.
    pub(super) path: Path,
    /// Time of the last request for a bin.
    pub(super) asked: Option<PolicyTime>,
}

impl Memory {
    /// Whether a restored memory can belong to the job of `setup`.
    pub(super) fn is_sound(&self, setup: &PalletizeSetup) -> bool {
        // Every index is checked: a checkpoint of another cell has valid bytes and would choose
        // wrong bins.
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
