//! Recorded messages of one topic, until they are no longer needed.

use std::collections::VecDeque;

use ipc_types::Header;

/// Key of a message of a topic: generation of its writer, and its number.
pub(super) type Key = (u32, u64);

/// Messages kept of a topic. A recorder that drains one topic after the other writes some
/// thousand messages of one before those of another that belong to them.
const ROOM: usize = 8192;

/// Messages that may wait for an input: half of `ROOM`, so the inputs of a waiting message are
/// still kept if they follow. One that has waited for longer needs an input that was not
/// recorded.
pub(super) const PATIENCE: usize = ROOM / 2;

/// The key of a message.
pub(super) fn key(header: &Header) -> Key {
    (header.generation, header.seq)
}

/// Result of a search for a message.
pub(super) enum Found<'a, T> {
    /// Found.
    Here(&'a T),
    /// It may still follow in the recording.
    NotYet,
    /// It was not recorded, or is too old.
    Lost,
}

/// Result of computing a message.
pub(super) enum Step {
    /// An input may still come.
    Wait,
    /// An input was not recorded.
    Lost,
    /// Computed and compared.
    Done,
}

impl<'a, T> Found<'a, T> {
    /// The message, or what its absence means for the computation.
    pub(super) fn here(self) -> Result<&'a T, Step> {
        match self {
            Found::Here(message) => Ok(message),
            Found::NotYet => Err(Step::Wait),
            Found::Lost => Err(Step::Lost),
        }
    }
}

/// Messages that are missing between two of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Missing {
    /// Generation of the writer.
    pub(super) generation: u32,
    /// The first that is missing.
    pub(super) first_seq: u64,
    /// How many.
    pub(super) count: u64,
}

/// Finds the gaps in the numbers of a topic.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sequence {
    newest: Option<Key>,
}

impl Sequence {
    /// Takes the next number and returns the gap before it. Messages sent before the recording
    /// started are not a gap.
    pub(super) fn take(&mut self, key: Key) -> Option<Missing> {
        let expected = match self.newest {
            Some(newest) if key <= newest => return None,
            Some((generation, seq)) if generation == key.0 => seq.saturating_add(1),
            // A restarted writer counts from 1.
            Some(_) => 1,
            None => key.1,
        };
        self.newest = Some(key);
        let count = key.1.saturating_sub(expected);
        (count > 0).then_some(Missing {
            generation: key.0,
            first_seq: expected,
            count,
        })
    }

    /// Whether a message with `key` cannot follow any more: numbers only grow.
    pub(super) fn is_past(&self, key: Key) -> bool {
        self.newest.is_some_and(|newest| newest >= key)
    }
}

/// The newest messages of one topic.
pub(super) struct MessageWindow<T> {
    kept: VecDeque<(Key, T)>,
    sequence: Sequence,
    ended: bool,
}

impl<T> Default for MessageWindow<T> {
    fn default() -> Self {
        Self {
            kept: VecDeque::new(),
            sequence: Sequence::default(),
            ended: false,
        }
    }
}

impl<T> MessageWindow<T> {
    /// Stores the next message; returns the gap before it.
    pub(super) fn put(&mut self, key: Key, message: T) -> Option<Missing> {
        // A duplicate in the queue would break its order, which `find` searches by halves.
        if self.sequence.is_past(key) {
            return None;
        }
        let missing = self.sequence.take(key);
        if self.kept.len() == ROOM {
            self.kept.pop_front();
        }
        self.kept.push_back((key, message));
        missing
    }

    /// Marks the end of the recording.
    pub(super) fn end(&mut self) {
        self.ended = true;
    }

    /// The message with `key`.
    pub(super) fn find(&self, key: Key) -> Found<'_, T> {
        let at = self.kept.partition_point(|(kept, _)| *kept < key);
        match self.kept.get(at) {
            Some((kept, message)) if *kept == key => Found::Here(message),
            _ if self.ended || self.sequence.is_past(key) => Found::Lost,
            _ => Found::NotYet,
        }
    }

    /// Whether a message with `key`, or a later one, was stored.
    pub(super) fn has(&self, key: Key) -> bool {
        self.sequence.is_past(key)
    }

    /// The messages after `key`, oldest first.
    pub(super) fn after(&self, key: Key) -> impl Iterator<Item = &(Key, T)> {
        let at = self.kept.partition_point(|(kept, _)| *kept <= key);
        self.kept.range(at..)
    }

    /// Whether the recording has ended.
    pub(super) fn has_ended(&self) -> bool {
        self.ended
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_come_is_waited_for_and_what_was_passed_over_is_lost() {
        let mut window = MessageWindow::default();
        assert_eq!(window.put((1, 5), 'a'), None);
        let hole = Missing {
            generation: 1,
            first_seq: 6,
            count: 2,
        };
        assert_eq!(window.put((1, 8), 'b'), Some(hole));
        assert_eq!(window.put((1, 8), 'c'), None);
        assert!(matches!(window.find((1, 8)), Found::Here('b')));
        assert!(matches!(window.find((1, 6)), Found::Lost));
        assert!(matches!(window.find((1, 9)), Found::NotYet));
        // A restarted writer counts from 1.
        assert_eq!(window.put((2, 1), 'd'), None);
        assert!(matches!(window.find((1, 9)), Found::Lost));
        window.end();
        assert!(matches!(window.find((2, 2)), Found::Lost));
    }
}
