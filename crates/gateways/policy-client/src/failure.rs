//! Why a server ends an episode.

use serde::{Deserialize, Serialize};

/// A stable name, and a sentence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// See [`reason`].
    pub reason: String,
    /// What happened, and what to do.
    pub message: String,
}

impl Failure {
    /// A failure with one of the names of [`reason`].
    pub(crate) fn new(reason: &str, message: impl Into<String>) -> Self {
        Self {
            reason: reason.to_owned(),
            message: message.into(),
        }
    }
}

/// Names of failures.
pub mod reason {
    /// The address has no server, or another one than a policy server.
    pub use cell_model::runs::policy_server::UNREACHABLE;
    /// The connection ended.
    pub const LOST: &str = "policy_connection_lost";
    /// No answer came in time.
    pub const LATE: &str = "policy_answer_late";
    /// An answer has no actions that can be executed.
    pub const INVALID: &str = "policy_answer_invalid";
    /// The server reports an error of its own.
    pub const ERROR: &str = "policy_error";
    /// The kept answers have none for an observation.
    pub const NOT_KEPT: &str = "policy_answer_not_kept";
}
