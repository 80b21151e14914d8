//! A message caused by tick k is used from tick k + 1 on, by every reader.
//!
//! What can go wrong: a message is delivered to its readers one after the other, so a fast
//! writer may answer tick k before a slow reader has looked at its inputs for tick k. Whether
//! the answer is used one tick earlier would then depend on the scheduler, and two runs of one
//! seed would differ. The rule: a reader working on tick k uses only messages whose cause is
//! before k, whether or not later ones have arrived (ADR 0004).
//!
//! A change must not break: the choice depends on headers only, never on time or arrival; a
//! reset of the scene or a new writer leaves nothing of the old one behind; no call after the
//! first message allocates.

use std::collections::VecDeque;

use ipc_types::header::Message;

use crate::message::TopicMessage;
use crate::subscriber::Subscriber;

/// A reader that is behind its writer by more than this loses the oldest message.
// One to use, one kept back, and as many again for a reader that was late by a cycle.
const WAITING: usize = 4;

/// Keeps messages back until the tick from which they may be used. A reader working on state
/// tick k gets the newest message with `header.tick < k`, whether or not a newer one has
/// arrived already: so the result does not depend on the speed of the processes.
#[derive(Clone, Debug)]
pub struct Gate<T: Message> {
    current: Option<Box<T>>,
    waiting: VecDeque<T>,
}

impl<T: Message> Default for Gate<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Message> Gate<T> {
    /// An empty gate; the only place that allocates, besides the first message.
    pub fn new() -> Self {
        Self {
            current: None,
            waiting: VecDeque::with_capacity(WAITING),
        }
    }

    /// Takes all messages waiting at `subscriber`; true if there was one. All, as the newest
    /// may have to be kept back and the one before it used.
    pub fn pull(&mut self, subscriber: &mut Subscriber<T>) -> bool
    where
        T: TopicMessage,
    {
        subscriber.take_all(|message| self.offer(message)) > 0
    }

    /// Takes one message. A tick before the last one (the scene was reset) empties the gate
    /// first; a new generation of the writer removes the waiting messages of the old one.
    pub fn offer(&mut self, message: &T) {
        // Compared with the newest message taken, whether it still waits or is in use already.
        let header = message.header();
        let last = self
            .waiting
            .back()
            .or(self.current.as_deref())
            .map(Message::header);
        if let Some(last) = last {
            // Ticks went back: the scene was reset, and everything
            // held belongs to the run before.
            if header.tick < last.tick {
                self.clear();
            } else if header.generation != last.generation {
                // No message of the old writer may be used after one of the new writer.
                self.waiting.retain(|old| old.header().tick < header.tick);
            }
        }
        // The writer answered one tick twice (it restarted): the later answer counts.
        if self
            .waiting
            .back()
            .is_some_and(|waiting| waiting.header().tick == header.tick)
        {
            self.waiting.pop_back();
        }
        // The capacity is fixed, so the queue never allocates in a cycle; the oldest would be
        // overtaken by the next anyway.
        if self.waiting.len() == WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(*message);
    }

    /// The message to use at state tick `tick`: the newest caused by an earlier
    /// one.
    pub fn advance(&mut self, tick: u64) -> Option<&T> {
        while self
            .waiting
            .front()
            .is_some_and(|message| message.header().tick < tick)
        {
            let Some(message) = self.waiting.pop_front() else {
                break;
            };
            // Only the first message allocates; later ones reuse its box.
            match &mut self.current {
                Some(current) => **current = message,
                None => self.current = Some(Box::new(message)),
            }
        }
        self.current()
    }

    /// Result of the last [`Self::advance`].
    pub fn current(&self) -> Option<&T> {
        self.current.as_deref()
    }

    /// Removes all messages, also the one in use.
    pub fn clear(&mut self) {
        self.current = None;
        self.waiting.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Decision, Header, Wire};

    fn decision(generation: u32, tick: u64) -> Decision {
        let mut decision = Decision::zeroed();
        decision.header = Header {
            generation,
            ..Header::caused_by::<Decision>(tick)
        };
        decision
    }

    fn used(gate: &mut Gate<Decision>, tick: u64) -> Option<(u32, u64)> {
        gate.advance(tick)
            .map(|decision| (decision.header.generation, decision.header.tick))
    }

    #[test]
    fn a_message_is_used_from_the_tick_after_its_cause() {
        let mut gate = Gate::new();
        gate.offer(&decision(1, 10));
        assert_eq!(used(&mut gate, 10), None);
        assert_eq!(used(&mut gate, 11), Some((1, 10)));
        gate.offer(&decision(1, 20));
        for tick in 12..=20 {
            assert_eq!(used(&mut gate, tick), Some((1, 10)), "tick {tick}");
        }
        assert_eq!(used(&mut gate, 21), Some((1, 20)));
    }

    #[test]
    fn it_does_not_matter_when_a_message_arrived() {
        // The same messages, each as early and as late as it can arrive.
        let (mut early, mut late) = (Gate::new(), Gate::new());
        for tick in 0..100_u64 {
            if tick % 10 == 0 {
                early.offer(&decision(1, tick));
            }
            if tick % 10 == 1 {
                late.offer(&decision(1, tick - 1));
            }
            assert_eq!(used(&mut early, tick), used(&mut late, tick), "tick {tick}");
        }
    }

    #[test]
    fn a_reader_that_is_behind_still_uses_the_right_one() {
        let mut gate = Gate::new();
        for tick in [10, 20, 30] {
            gate.offer(&decision(1, tick));
        }
        assert_eq!(used(&mut gate, 15), Some((1, 10)));
        assert_eq!(used(&mut gate, 31), Some((1, 30)));
    }

    #[test]
    fn after_a_reset_nothing_of_before_is_used() {
        let mut gate = Gate::new();
        gate.offer(&decision(1, 500));
        assert!(gate.advance(501).is_some());
        gate.offer(&decision(1, 0));
        assert_eq!(used(&mut gate, 0), None);
        assert_eq!(used(&mut gate, 1), Some((1, 0)));
    }

    #[test]
    fn a_restarted_writer_replaces_what_still_waits() {
        let mut gate = Gate::new();
        gate.offer(&decision(1, 10));
        gate.advance(11);
        gate.offer(&decision(1, 20));
        gate.offer(&decision(2, 20));
        assert_eq!(used(&mut gate, 20), Some((1, 10)));
        assert_eq!(used(&mut gate, 21), Some((2, 20)));
    }

    #[test]
    fn a_message_sent_again_for_the_same_tick_replaces_the_first() {
        let mut gate = Gate::new();
        for drops in 1..=20 {
            gate.offer(&Decision {
                drops,
                ..decision(1, 10)
            });
        }
        assert_eq!(gate.advance(11).map(|decision| decision.drops), Some(20));
    }
}
