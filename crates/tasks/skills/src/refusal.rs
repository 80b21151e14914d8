//! Why a skill did not start.

use robocell_task::Reason;

/// Why a skill did not start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Stable name.
    pub reason: Reason,
    /// The same with names and numbers.
    pub why: String,
}
