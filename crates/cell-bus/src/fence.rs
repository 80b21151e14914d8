//! Which of the messages that arrive may be used. Pure.

use ipc_types::Header;

/// What a reader met on one topic since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages used.
    pub accepted: u64,
    /// Messages dropped because a value in them makes no sense, or because they
    /// are of another run or type.
    pub rejected: u64,
    /// Messages dropped because a later start of the writer has spoken already,
    /// or because they are older than one that was used.
    pub fenced: u64,
    /// Messages that were sent but overwritten before this reader looked.
    pub late: u64,
}

/// What to do with one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Admission {
    Accept,
    Drop,
}

/// Remembers the newest writer and message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fence {
    run: u64,
    schema: u64,
    generation: u32,
    seq: u64,
    pub(crate) counts: Counts,
}

impl Fence {
    pub(crate) fn new(run: u64, schema: u64) -> Self {
        Self {
            run,
            schema,
            generation: 0,
            seq: 0,
            counts: Counts::default(),
        }
    }

    /// Generation of the newest writer heard; 0 before the first.
    pub(crate) fn generation(&self) -> u32 {
        self.generation
    }

    /// Judges a message by its header and by whether its content is `valid`,
    /// and counts it.
    pub(crate) fn judge(&mut self, header: &Header, valid: bool) -> Admission {
        let ours = header.run == self.run && header.schema == self.schema && header.seq > 0;
        if !ours {
            self.counts.rejected += 1;
            return Admission::Drop;
        }
        let newer = header.generation > self.generation;
        if !newer && (header.generation < self.generation || header.seq <= self.seq) {
            self.counts.fenced += 1;
            return Admission::Drop;
        }
        if !newer {
            self.counts.late += header.seq - self.seq - 1;
        }
        // An invalid message still moves the fence: its writer is the newest.
        self.generation = header.generation;
        self.seq = header.seq;
        if !valid {
            self.counts.rejected += 1;
            return Admission::Drop;
        }
        self.counts.accepted += 1;
        Admission::Accept
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn header(generation: u32, seq: u64) -> Header {
        Header {
            run: 7,
            schema: 9,
            generation,
            seq,
            ..Header::zeroed()
        }
    }

    fn heard(messages: &[(u32, u64)]) -> (Vec<bool>, Counts) {
        let mut fence = Fence::new(7, 9);
        let accepted = messages
            .iter()
            .map(|(generation, seq)| {
                fence.judge(&header(*generation, *seq), true) == Admission::Accept
            })
            .collect();
        (accepted, fence.counts)
    }

    #[test]
    fn a_stopped_writer_that_wakes_up_is_not_heard_again() {
        let (accepted, counts) = heard(&[(1, 10), (1, 11), (2, 1), (1, 12), (2, 2), (1, 13)]);
        assert_eq!(accepted, [true, true, true, false, true, false]);
        assert_eq!(
            counts,
            Counts {
                accepted: 4,
                rejected: 0,
                fenced: 2,
                late: 0
            }
        );
    }

    #[test]
    fn what_was_overwritten_is_counted_within_one_generation() {
        let (_, counts) = heard(&[(1, 5), (1, 6), (1, 10), (3, 40), (3, 42)]);
        assert_eq!(counts.late, 3 + 1);
    }

    #[test]
    fn the_same_message_twice_is_used_once() {
        let (accepted, counts) = heard(&[(1, 1), (1, 1)]);
        assert_eq!(accepted, [true, false]);
        assert_eq!(counts.fenced, 1);
    }

    #[test]
    fn strangers_are_rejected_and_move_nothing() {
        let mut fence = Fence::new(7, 9);
        for stranger in [
            Header {
                run: 8,
                ..header(5, 5)
            },
            Header {
                schema: 1,
                ..header(5, 5)
            },
            Header {
                seq: 0,
                ..header(5, 5)
            },
        ] {
            assert_eq!(fence.judge(&stranger, true), Admission::Drop);
        }
        assert_eq!(fence.generation(), 0);
        assert_eq!(fence.judge(&header(1, 1), true), Admission::Accept);
        assert_eq!(fence.counts.rejected, 3);
    }

    #[test]
    fn nonsense_of_a_new_writer_still_silences_the_old_one() {
        let mut fence = Fence::new(7, 9);
        fence.judge(&header(1, 1), true);
        assert_eq!(fence.judge(&header(2, 1), false), Admission::Drop);
        assert_eq!(fence.judge(&header(1, 2), true), Admission::Drop);
        assert_eq!(
            fence.counts,
            Counts {
                accepted: 1,
                rejected: 1,
                fenced: 1,
                late: 0
            }
        );
    }
}
