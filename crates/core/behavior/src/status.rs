//! The results of nodes, and their statuses for observers.

use serde::{Deserialize, Serialize};

/// The result of a tick of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Status {
    /// Not finished.
    Running = 1,
    /// Finished as intended.
    Success = 2,
    /// Finished otherwise.
    Failure = 3,
}

impl Status {
    /// `R`, `S` or `F`.
    pub fn letter(self) -> char {
        NodeStatus::from(self).letter()
    }
}

/// The status of a node after a tick. Of a machine, `Running` is a state that is
/// active, `Invalid` one that is not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum NodeStatus {
    /// Never ran, or was stopped.
    #[default]
    Invalid = 0,
    /// Not finished.
    Running = 1,
    /// Finished as intended.
    Success = 2,
    /// Finished otherwise.
    Failure = 3,
    /// Was told to stop and needs more ticks.
    Halting = 4,
}

impl NodeStatus {
    /// `-`, `R`, `S`, `F` or `H`.
    pub fn letter(self) -> char {
        match self {
            Self::Invalid => '-',
            Self::Running => 'R',
            Self::Success => 'S',
            Self::Failure => 'F',
            Self::Halting => 'H',
        }
    }

    /// The status with that letter.
    pub fn from_letter(letter: char) -> Option<Self> {
        let all = [
            Self::Invalid,
            Self::Running,
            Self::Success,
            Self::Failure,
            Self::Halting,
        ];
        all.into_iter().find(|status| status.letter() == letter)
    }

    /// The result of the node, if it is neither stopped nor stopping.
    pub fn answer(self) -> Option<Status> {
        match self {
            Self::Running => Some(Status::Running),
            Self::Success => Some(Status::Success),
            Self::Failure => Some(Status::Failure),
            Self::Invalid | Self::Halting => None,
        }
    }
}

impl From<Status> for NodeStatus {
    // The numbers are the same, so that this costs nothing.
    #[inline]
    fn from(status: Status) -> Self {
        match status {
            Status::Running => Self::Running,
            Status::Success => Self::Success,
            Status::Failure => Self::Failure,
        }
    }
}

/// Why a node was told to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum ResetReason {
    /// The whole behaviour was reset from outside.
    Explicit = 0,
    /// A branch of higher priority took over.
    Preempted = 1,
    /// A condition attached to it, or to a node around it, does not hold.
    Aborted = 2,
    /// Its parent finished without it.
    ParentDone = 3,
    /// Its time limit has passed.
    TimedOut = 4,
}

impl ResetReason {
    /// Word in logs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit => "reset",
            Self::Preempted => "preempted",
            Self::Aborted => "aborted",
            Self::ParentDone => "parent done",
            Self::TimedOut => "timed out",
        }
    }
}
