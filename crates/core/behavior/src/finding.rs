//! A finding of a static check.

/// A probable mistake in a behaviour that loads and runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Stable name of the kind of finding, `like_this`.
    pub rule: &'static str,
    /// Its place: id of the node, state, row or key.
    pub place: String,
    /// The finding, and the correction.
    pub message: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} [{}]", self.place, self.message, self.rule)
    }
}
