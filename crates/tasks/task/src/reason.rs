//! The reason of a failed job, as text: a stable name for scripts.

use ipc_types::Text;
use serde::{Deserialize, Serialize};

/// Stable name of a failure: lower case words with underscores, at most
/// [`Reason::MAX_BYTES`]. The summary of a run and the decision carry it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason(Text<{ Self::MAX_BYTES }>);

impl Reason {
    /// Longest name.
    pub const MAX_BYTES: usize = ipc_types::decision::REASON_BYTES;

    /// A reason; a longer name is cut and ends with `…`.
    pub fn new(name: &str) -> Self {
        Self(Text::new(name))
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        self.0.as_str()
    }

    /// The name, as messages carry it.
    pub fn text(self) -> Text<{ Self::MAX_BYTES }> {
        self.0
    }
}

impl From<&str> for Reason {
    fn from(name: &str) -> Self {
        Self::new(name)
    }
}

impl Serialize for Reason {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for Reason {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|name| Self::new(&name))
    }
}
