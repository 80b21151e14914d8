//! The record a task can be continued from: plain data behind a version.

use bincode::Options as _;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::goal_book::GoalBook;
use crate::job::Job;
use crate::operator::PanelMemory;
use crate::time::PolicyClock;

/// Version of the layout; another one is refused, and the task begins from what
/// it observes.
pub const RECORD_VERSION: u32 = 3;

/// A record is never longer, so a broken length cannot ask for more memory.
pub const MAX_RECORD_BYTES: u64 = 64 * 1024;

#[derive(Serialize, Deserialize)]
pub(crate) struct TaskRecord {
    pub(crate) version: u32,
    pub(crate) demo: String,
    pub(crate) policy: String,
    pub(crate) job: Job,
    pub(crate) clock: PolicyClock,
    pub(crate) panel: PanelMemory,
    pub(crate) goals: GoalBook,
    pub(crate) unsure: bool,
    #[serde(with = "serde_bytes")]
    pub(crate) policy_state: Vec<u8>,
}

impl TaskRecord {
    /// Whether all that is counted in it can be counted on.
    pub(crate) fn is_sound(&self) -> bool {
        self.job.is_sound() && self.clock.is_sound() && self.goals.is_sound()
    }
}

/// Why a record was not taken.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Not a record, or a damaged one.
    #[error("the task's record cannot be read: {0}; the task has to start without it")]
    Unreadable(#[from] bincode::Error),
    /// Written by another version.
    #[error(
        "the task's record has layout version {found}, this build reads {RECORD_VERSION}; the task has to start without it"
    )]
    Version {
        /// Version in the record.
        found: u32,
    },
    /// Written for another cell.
    #[error(
        "the task's record is of demo '{found}', this cell is '{expected}'; the task has to start without it"
    )]
    OtherCell {
        /// Demo in the record.
        found: String,
        /// Demo of this task.
        expected: String,
    },
}

/// Plain little-endian bytes; floats bit by bit. Empty, which no reader takes
/// for a record, if `value` were longer than [`MAX_RECORD_BYTES`].
pub(crate) fn to_bytes<T: Serialize>(value: &T) -> Vec<u8> {
    options().serialize(value).unwrap_or_default()
}

/// Refuses damaged, foreign and over-long bytes.
pub(crate) fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, bincode::Error> {
    options().deserialize(bytes)
}

/// Version of a record, readable whatever follows it.
pub(crate) fn version(bytes: &[u8]) -> Result<u32, bincode::Error> {
    options().allow_trailing_bytes().deserialize(bytes)
}

fn options() -> impl bincode::Options {
    bincode::DefaultOptions::new()
        .with_fixint_encoding()
        .with_limit(MAX_RECORD_BYTES)
}
