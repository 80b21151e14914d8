//! What a modelled process may still do before it is killed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts what other processes can notice of the process whose turn it is: messages, doorbells,
/// replies, stores in files. A process that is killed in the middle of a turn has had the first
/// of them. Its clones count together.
#[derive(Clone, Debug)]
pub struct Effects(Arc<AtomicU64>);

impl Default for Effects {
    /// All of them happen.
    fn default() -> Self {
        Self(Arc::new(AtomicU64::new(u64::MAX)))
    }
}

impl Effects {
    /// Lets the next `count` effects happen and none after them.
    pub fn allow(&self, count: u64) {
        self.0.store(count, Ordering::Relaxed);
    }

    /// How many may still happen.
    pub fn left(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    /// Whether the effect that is due happens.
    pub fn happens(&self) -> bool {
        let left = self.left();
        self.allow(left.saturating_sub(1));
        left > 0
    }
}
