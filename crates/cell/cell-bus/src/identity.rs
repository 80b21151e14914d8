//! Identity of a process.

/// Identity of a process, stamped on all its messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    pub(crate) run: u64,
    pub(crate) generation: u32,
}
