//! Who a process is.

/// Who a process is: stamped on all it sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    pub(crate) run: u64,
    pub(crate) generation: u32,
}
