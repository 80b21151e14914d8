//! Messages of another process that a loop uses for a tick.

use cell_bus::{Counts, Gate, Subscriber, TopicMessage};
use ipc_types::Invalid;

/// Longest wait of lockstep for a message that was sent, but has not reached this reader (ns).
// Bounded: its writer may have been killed in between and has to start again, and a cell that
// waits for ever cannot be repaired by its supervisor.
pub const DELIVERY_NS: u64 = 2_000_000_000;

/// A reader with a [`Gate`]: the message for a tick does not depend on the scheduler (ADR
/// 0004).
pub struct Gated<T: TopicMessage> {
    subscriber: Subscriber<T>,
    gate: Gate<T>,
}

impl<T: TopicMessage> Gated<T> {
    /// The input of the messages of `subscriber`.
    pub fn new(subscriber: Subscriber<T>) -> Self {
        Self {
            subscriber,
            gate: Gate::new(),
        }
    }

    /// Takes the messages that arrived and chooses the newest one that was caused before
    /// `tick`. True if it answers physics `generation` and was caused by tick `wanted` or a
    /// later one; in lockstep this is called again until it does, [`DELIVERY_NS`] at most.
    pub fn choose(&mut self, generation: u32, tick: u64, wanted: Option<u64>) -> bool {
        self.gate.pull(&mut self.subscriber);
        self.gate.advance(tick);
        self.get(generation).map(|found| found.header().tick) >= wanted
    }

    /// The message that was chosen last, if it answers physics `generation`.
    // Another start of physics has a world that no longer exists.
    pub fn get(&self, generation: u32) -> Option<&T> {
        let chosen = self.gate.current();
        chosen.filter(|message| message.header().answers(generation))
    }

    /// Removes all messages: after a reset of the scene or a restart of physics, those of
    /// before would pass as newer, since their ticks are larger.
    pub fn clear(&mut self) {
        self.gate.clear();
    }

    /// Numbers of messages accepted and dropped.
    pub fn counts(&self) -> Counts {
        self.subscriber.counts()
    }

    /// As [`Subscriber::take_invalid`].
    pub fn take_invalid(&mut self) -> Option<Invalid> {
        self.subscriber.take_invalid()
    }
}
