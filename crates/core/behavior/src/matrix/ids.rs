//! Small numbers that replace names of a matrix.

/// Largest number of events of a matrix.
// An `EventSet` is one word of 64 bits.
pub const MAX_EVENTS: usize = 64;
/// Largest number of handlers of a matrix.
// Each may have a tree of its own, which is loaded with the file.
pub(super) const MAX_HANDLERS: usize = 4_096;

/// An event: its place in [`Vocabulary::events`], or in the precedence list if
/// that is empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EventId(pub u16);

/// A handler: its place in [`Vocabulary::handlers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct HandlerId(pub u16);

/// Events that are pending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EventSet(u64);

impl EventSet {
    /// None.
    pub const EMPTY: Self = Self(0);

    /// With `event`; one beyond [`MAX_EVENTS`] is ignored.
    #[must_use]
    pub fn with(self, event: EventId) -> Self {
        // `checked_shl`: an id from another matrix must not set a wrong bit.
        Self(self.0 | 1_u64.checked_shl(u32::from(event.0)).unwrap_or(0))
    }

    /// Whether `event` is pending.
    pub fn contains(self, event: EventId) -> bool {
        self.0 & Self::EMPTY.with(event).0 != 0
    }
}

/// Names that a host implements. A file that uses others is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vocabulary<'a> {
    /// Events that the host raises; if empty, those of the precedence list.
    pub events: &'a [&'a str],
    /// States to which the host's handlers change, and the order of their ids; if empty,
    /// the order of the file.
    pub states: &'a [&'a str],
    /// Handlers of the host.
    pub handlers: &'a [&'a str],
    /// Sub-behaviours a state may run.
    pub behaviors: &'a [&'a str],
}
