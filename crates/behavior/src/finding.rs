//! What a static check found.

/// Something in a behaviour that loads and runs, but is probably not meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Stable name of the kind of finding, `like_this`.
    pub rule: &'static str,
    /// Where: id of the node, state, row or key.
    pub place: String,
    /// What, and what to do.
    pub message: String,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} [{}]", self.place, self.message, self.rule)
    }
}
