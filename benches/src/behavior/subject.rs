//! The work of one row.

/// Work that can be repeated.
pub struct Subject {
    /// Name of the row.
    pub(crate) name: &'static str,
    /// The row that is compared with this one.
    pub(crate) peer_of: Option<&'static str>,
    /// Does the work that many times.
    pub(crate) work: Box<dyn FnMut(u64)>,
}

impl Subject {
    /// Work without comparison.
    pub fn new(name: &'static str, work: impl FnMut(u64) + 'static) -> Self {
        Self {
            name,
            peer_of: None,
            work: Box::new(work),
        }
    }

    /// The same; the row `own` is compared with it.
    #[must_use]
    pub fn peer_of(self, own: &'static str) -> Self {
        Self {
            peer_of: Some(own),
            ..self
        }
    }
}
