//! Small numbers for names of a matrix.

/// Most events of a matrix.
pub const MAX_EVENTS: usize = 64;
/// Most handlers of a matrix.
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
        Self(self.0 | 1_u64.checked_shl(u32::from(event.0)).unwrap_or(0))
    }

    /// Whether `event` is pending.
    pub fn contains(self, event: EventId) -> bool {
        self.0 & Self::EMPTY.with(event).0 != 0
    }
}

/// Names that a host can give a meaning to. A file that uses others is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vocabulary<'a> {
    /// Events the host raises; if empty, the precedence list names them.
    pub events: &'a [&'a str],
    /// States the host's handlers go to, and the order of their ids; if empty,
    /// the order of the file.
    pub states: &'a [&'a str],
    /// Handlers the host has.
    pub handlers: &'a [&'a str],
    /// Sub-behaviours a state may run.
    pub behaviors: &'a [&'a str],
}
