//! The work of one row.

/// Work that can be repeated.
pub(crate) struct Subject {
    /// Name of the row.
    pub(crate) name: &'static str,
    /// Row it is compared with.
    pub(crate) against: Option<&'static str>,
    /// Does the work that many times.
    pub(crate) work: Box<dyn FnMut(u64)>,
}

impl Subject {
    /// Work without comparison.
    pub(crate) fn new(name: &'static str, work: impl FnMut(u64) + 'static) -> Self {
        Self {
            name,
            against: None,
            work: Box::new(work),
        }
    }

    /// The same, compared with the row `peer`.
    pub(crate) fn against(self, peer: &'static str) -> Self {
        Self {
            against: Some(peer),
            ..self
        }
    }
}
