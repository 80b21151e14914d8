//! The record from which a task resumes after its process was killed: plain data behind
//! a version number.
//!
//! It is written with every decision, before the decision is published. A process that
//! is killed at any instant therefore leaves a checkpoint that is not older than the
//! decision that the cell follows.
//!
//! What can go wrong, and the rule that prevents it:
//! - a field that is remembered but not saved: the restored task decides differently from
//!   the one that was killed, and the cube in the gripper is dropped. All memory of a task
//!   is in `TaskCheckpoint`; leaves of trees cannot keep any (ADR 0008);
//! - another layout, or bytes that happen to decode: `VERSION` comes first and is compared
//!   before anything else is decoded;
//! - bytes that decode into counters near their maximum, on which the next addition would
//!   overflow: `is_sound` bounds every counter before it is used;
//! - a damaged length that asks for gigabytes: decoding is limited by the bytes at hand.
//!
//! A change of any type in the record needs a new `VERSION`. A change must keep the
//! encoding free of pointers, maps with random order and clocks: equal tasks have equal
//! bytes, which the tests compare.

use bincode::Options as _;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::breakpoints::Breakpoints;
use crate::goal_book::GoalBook;
use crate::job::Job;
use crate::operator::PanelState;
use crate::time::PolicyClock;

/// Version of the layout; a checkpoint with another version is refused, and the task
/// starts from its observation.
// Read before all else; a build with another layout must not decode by chance.
pub const VERSION: u32 = 11;

/// Longest checkpoint that is kept for a successor of the process and recorded (bytes).
/// It is written with every decision: at 100 Hz, this much takes most of a core.
pub const MAX_BYTES: usize = 16 * 1024 * 1024;

#[derive(Serialize, Deserialize)]
pub(crate) struct TaskCheckpoint {
    pub(crate) version: u32,
    pub(crate) demo: String,
    pub(crate) policy: String,
    pub(crate) job: Job,
    /// The phase that was counted last.
    pub(crate) phase: String,
    pub(crate) clock: PolicyClock,
    pub(crate) panel: PanelState,
    pub(crate) goals: GoalBook,
    pub(crate) breakpoints: Breakpoints,
    pub(crate) unsure: bool,
    #[serde(with = "serde_bytes")]
    pub(crate) policy_state: Vec<u8>,
}

impl TaskCheckpoint {
    /// Whether every counter in it is in a range from which counting can continue.
    pub(crate) fn is_sound(&self) -> bool {
        self.job.is_sound() && self.clock.is_sound() && self.goals.is_sound()
    }
}

/// Why a checkpoint was refused.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// Not a checkpoint, or a damaged one.
    #[error("the task's checkpoint cannot be read: {0}; the task starts without it")]
    Unreadable(#[from] bincode::Error),
    /// Written by another version.
    #[error(
        "the task's checkpoint has layout version {found}, this build reads {VERSION}; the task starts without it"
    )]
    Version {
        /// Version in the checkpoint.
        found: u32,
    },
    /// Written for another cell.
    #[error(
        "the task's checkpoint is of demo '{found}', this cell is '{expected}'; the task starts without it"
    )]
    OtherCell {
        /// Demo in the checkpoint.
        found: String,
        /// Demo of this task.
        expected: String,
    },
}

/// Plain little-endian bytes; floats bit by bit. Of any length: the program that keeps
/// them has the limit. Empty, which no reader takes for a checkpoint, where `value`
/// cannot be serialised.
pub fn to_bytes<T: Serialize>(value: &T) -> Vec<u8> {
    // No limit here: the program that stores a checkpoint reports its size and `MAX_BYTES`.
    options(usize::MAX).serialize(value).unwrap_or_default()
}

/// Reads what [`to_bytes`] wrote.
///
/// # Errors
/// For damaged, foreign and over-long bytes.
pub fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, bincode::Error> {
    options(bytes.len()).deserialize(bytes)
}

/// Version of a checkpoint, readable whatever follows it.
pub(crate) fn version(bytes: &[u8]) -> Result<u32, bincode::Error> {
    options(bytes.len())
        .allow_trailing_bytes()
        .deserialize(bytes)
}

/// `most` keeps a broken length from asking for more memory than the bytes can fill.
fn options(most: usize) -> impl bincode::Options {
    bincode::DefaultOptions::new()
        .with_fixint_encoding()
        .with_limit(most as u64)
}
