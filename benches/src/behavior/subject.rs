//! What one row measures.

/// Work that can be repeated.
pub(crate) struct Subject {
    /// Name of the row.
    pub(crate) name: &'static str,
    /// Row it is held against.
    pub(crate) against: Option<&'static str>,
    /// Does the work so many times.
    pub(crate) work: Box<dyn FnMut(u64)>,
}

impl Subject {
    /// Work held against nothing.
    pub(crate) fn new(name: &'static str, work: impl FnMut(u64) + 'static) -> Self {
        Self {
            name,
            against: None,
            work: Box::new(work),
        }
    }

    /// The same, held against the row `peer`.
    pub(crate) fn against(self, peer: &'static str) -> Self {
        Self {
            against: Some(peer),
            ..self
        }
    }
}
