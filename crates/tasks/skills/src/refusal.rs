//! Why a skill did not start, and what an arm waits for.

use behavior::Str;
use robocell_task::Reason;

/// Why a skill did not start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Stable name.
    pub reason: Reason,
    /// The same with names and numbers.
    pub why: String,
}

/// What an arm waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ZoneWait {
    /// The zone.
    pub zone: Str,
    /// Name of the arm that owns it.
    pub owner: Str,
}
