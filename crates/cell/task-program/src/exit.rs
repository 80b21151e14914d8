//! Exit codes of a task program.

/// A file or a name that cannot be used, or a policy server that no episode reached.
pub(crate) const CONFIGURATION: u8 = 3;
/// A task that failed or timed out; a recording that differs.
// Apart from 2, with which the parser of the command line ends.
pub(crate) const TASK_FAILED: u8 = 5;
/// A stopped evaluation, as shells report one that SIGINT ended.
// Apart from 0 and 5: the same command, repeated, resumes.
pub(crate) const STOPPED: u8 = 130;
