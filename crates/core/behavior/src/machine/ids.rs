//! Small numbers that replace names once a file is loaded.

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u16);

        impl $name {
            /// As an index.
            pub fn index(self) -> usize {
                usize::from(self.0)
            }

            /// From an index; one beyond 16 bits, which loading refuses, becomes the largest
            /// number.
            pub(crate) fn of(index: usize) -> Self {
                Self(u16::try_from(index).unwrap_or(u16::MAX))
            }
        }
    };
}

id!(
    /// A state, in the order of the file: a parent, then its children.
    StateId
);
id!(
    /// A trigger: its place in [`Vocabulary::triggers`]; those that are not in
    /// there (automatic and ordered ones, or all if it is empty) follow in the
    /// order of the file.
    TriggerId
);
id!(
    /// A guard: its place in [`Vocabulary::guards`].
    GuardId
);
id!(
    /// A callback: its place in [`Vocabulary::callbacks`].
    CallbackId
);
id!(
    /// A sub-behaviour: its place in [`Vocabulary::behaviors`].
    BehaviorId
);
id!(
    /// A row as declared; ordered and automatic rows follow the written ones.
    RowId
);

/// Names that a host implements. A file that uses others is refused.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vocabulary<'a> {
    /// Triggers that the host fires; if empty, any trigger of a row is known.
    pub triggers: &'a [&'a str],
    /// Guards that the host evaluates.
    pub guards: &'a [&'a str],
    /// Callbacks that the host runs.
    pub callbacks: &'a [&'a str],
    /// Sub-behaviours a state may run.
    pub behaviors: &'a [&'a str],
}
