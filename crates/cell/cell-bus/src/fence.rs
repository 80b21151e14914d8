//! Decides which of the arriving messages may be used. Pure.
//!
//! What can go wrong: a process that was stopped and replaced wakes up and publishes again, and
//! a bit of a header can be flipped in shared memory.
//!
//! The rule: the newest generation is used, and nothing of an older one. A process has one port
//! on a topic and one generation for life, and a port delivers in the order of publication. So
//! a header that contradicts earlier ones of *its own port* is damaged, and is not evidence
//! about the writer; only another port can replace it. Without the port, one flipped bit in a
//! generation looked like a successor, and the writer was ignored until it restarted.
//!
//! A change must not break: messages of a replaced port are never used, regardless of what they
//! claim; a message is used once, and none after a later one; one damaged header costs one message, not the writer. The port id comes from
//! the connection, not from the message.

use ipc_types::Header;

/// What a reader met on one topic since it was opened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages used.
    pub accepted: u64,
    /// Messages dropped because a value in them makes no sense, or because they
    /// are of another run or type.
    pub rejected: u64,
    /// Messages dropped because a later start of the writer has published already,
    /// or because they were used before.
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

/// A port that publishes, by its headers.
#[derive(Clone, Copy, Debug)]
struct Writer {
    port: u128,
    generation: u32,
    /// Whether two messages in a row carried this generation: one alone may be damaged.
    confirmed: bool,
    seq: u64,
    /// When the last message was published.
    publish_ns: u64,
    /// Messages counted as late with the last one.
    gap: u64,
    /// A number that went back, and was taken for damaged.
    went_back: Option<u64>,
}

impl Writer {
    fn new(port: u128, header: &Header) -> Self {
        Self {
            port,
            generation: header.generation,
            confirmed: false,
            seq: header.seq,
            publish_ns: header.publish_ns,
            gap: 0,
            went_back: None,
        }
    }

    /// Takes `seq` as the newest number; returns by how many messages fewer or more are
    /// missing. A number that goes back shows that it or the one before was damaged.
    fn advance(&mut self, seq: u64) -> i128 {
        // Both memories are of the last message only: kept longer, two unrelated damages would
        // look like one correction.
        let gap = std::mem::take(&mut self.gap);
        let went_back = self.went_back.take();
        if seq > self.seq {
            self.gap = seq - self.seq - 1;
            self.seq = seq;
            return self.gap.into();
        }
        // A number that went back: either it is damaged, or the one before was too large.
        let before_last = self.seq - 1 - gap;
        if seq > before_last || went_back.is_some_and(|before| seq > before) {
            // The message before was damaged: its gap is taken back.
            self.seq = seq;
            return -i128::from(gap);
        }
        // Counted as one step, so that the next good message does not show a gap.
        self.went_back = Some(seq);
        self.seq = self.seq.saturating_add(1);
        0
    }
}

/// Remembers the newest writer and message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fence {
    run: u64,
    schema: u64,
    newest: Option<Writer>,
    /// The one that `newest` replaced.
    replaced: Option<Writer>,
    pub(crate) counts: Counts,
}

impl Fence {
    pub(crate) fn new(run: u64, schema: u64) -> Self {
        Self {
            run,
            schema,
            newest: None,
            replaced: None,
            counts: Counts::default(),
        }
    }

    /// Generation of the newest writer; 0 before its first message.
    pub(crate) fn generation(&self) -> u32 {
        self.newest.map_or(0, |writer| writer.generation)
    }

    /// Judges a message from `port` by its header and by whether its content is
    /// `valid`, and counts it.
    pub(crate) fn judge(&mut self, port: u128, header: &Header, valid: bool) -> Admission {
        let ours = header.run == self.run && header.schema == self.schema && header.seq > 0;
        // Checked first: a message of another run or type must not move the fence.
        if !ours {
            self.counts.rejected += 1;
            return Admission::Drop;
        }
        // An invalid message still moves the fence: its writer is the newest.
        let admission = match self.newest {
            // A known port continues; any other port claims to be
            // a successor and has to prove it.
            Some(writer) if writer.port == port => self.next(writer, header),
            _ => self.first(port, header),
        };
        match admission {
            Admission::Drop => Admission::Drop,
            Admission::Accept if valid => {
                self.counts.accepted += 1;
                Admission::Accept
            }
            Admission::Accept => {
                self.counts.rejected += 1;
                Admission::Drop
            }
        }
    }

    /// One more message of the newest port, which is `writer`.
    fn next(&mut self, mut writer: Writer, header: &Header) -> Admission {
        if header.generation == writer.generation {
            writer.confirmed = true;
        // A port has one generation for life, so a different
        // one after two equal ones is damage.
        } else if writer.confirmed {
            self.counts.rejected += 1;
            return Admission::Drop;
        } else if let Some(replaced) = self.replaced.filter(|r| header.generation < r.generation) {
            // The only message that made this port the newest was damaged.
            (self.newest, self.replaced) = (Some(replaced), None);
            self.counts.fenced += 1;
            return Admission::Drop;
        } else {
            writer.generation = header.generation;
        }
        // The same number twice: regardless of the cause, a message has one effect only.
        if header.seq == writer.seq {
            self.newest = Some(writer);
            self.counts.fenced += 1;
            return Admission::Drop;
        }
        // Number and time both went back: it came again, or was overtaken. One alone is damaged.
        if header.seq < writer.seq && header.publish_ns <= writer.publish_ns {
            self.newest = Some(writer);
            self.counts.fenced += 1;
            return Admission::Drop;
        }
        writer.publish_ns = header.publish_ns;
        let missing = writer.advance(header.seq);
        let late = i128::from(self.counts.late) + missing;
        // Saturates: a damaged number can lead to more being taken back than was counted.
        self.counts.late = u64::try_from(late.max(0)).unwrap_or(u64::MAX);
        self.newest = Some(writer);
        Admission::Accept
    }

    /// A message of a port that is not the newest.
    fn first(&mut self, port: u128, header: &Header) -> Admission {
        let is_replaced = self.replaced.is_some_and(|r| r.port == port);
        // Here a process that was stopped, replaced and continued is refused: without this rule
        // a reader alternated between both writers 1,133 times in 0.6 s.
        if is_replaced || header.generation < self.generation() {
            self.counts.fenced += 1;
            return Admission::Drop;
        }
        // A port of the same generation is that of a process which opened it again.
        if header.generation > self.generation() {
            self.replaced = self.newest;
        }
        self.newest = Some(Writer::new(port, header));
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

    /// Whether each message was used, given its port, generation and number.
    fn heard(fence: &mut Fence, messages: &[(u128, u32, u64)]) -> Vec<bool> {
        let counts = fence.counts;
        let before = counts.accepted + counts.rejected + counts.fenced;
        // Published one after the other, whatever their numbers say.
        let times = before + 1..;
        let judged = messages.iter().zip(times);
        let judged = judged.map(|((port, generation, seq), publish_ns)| {
            let header = Header {
                publish_ns,
                ..header(*generation, *seq)
            };
            fence.judge(*port, &header, true) == Admission::Accept
        });
        judged.collect()
    }

    /// Whether messages of one writer, each published at the time that is its number, are used.
    fn heard_in(order: &[u64]) -> Vec<bool> {
        let mut fence = fence();
        let judged = order.iter().map(|seq| {
            let header = Header {
                publish_ns: *seq,
                ..header(1, *seq)
            };
            fence.judge(1, &header, true) == Admission::Accept
        });
        judged.collect()
    }

    fn flipped(number: u64, bit: u32) -> u64 {
        number ^ (1 << bit)
    }

    fn fence() -> Fence {
        Fence::new(7, 9)
    }

    #[test]
    fn a_stopped_writer_that_wakes_up_is_not_heard_again() {
        let mut fence = fence();
        let messages = [
            (1, 1, 10),
            (1, 1, 11),
            (2, 2, 1),
            (1, 1, 12),
            (2, 2, 2),
            (1, 1, 13),
        ];
        let accepted = heard(&mut fence, &messages);
        assert_eq!(accepted, [true, true, true, false, true, false]);
        assert_eq!(
            fence.counts,
            Counts {
                accepted: 4,
                rejected: 0,
                fenced: 2,
                late: 0
            }
        );
    }

    #[test]
    fn a_successor_of_one_message_silences_the_stopped_writer_for_good() {
        let mut fence = fence();
        heard(&mut fence, &[(1, 1, 10), (1, 1, 11), (2, 2, 1)]);
        let zombie: Vec<(u128, u32, u64)> = (12..200).map(|seq| (1, 1, seq)).collect();
        assert!(!heard(&mut fence, &zombie).contains(&true));
        assert_eq!(heard(&mut fence, &[(2, 2, 2)]), [true]);
    }

    #[test]
    fn a_flipped_bit_in_a_generation_costs_its_message_only() {
        for bit in 0..u32::BITS {
            let mut fence = fence();
            heard(&mut fence, &[(1, 2, 10), (1, 2, 11)]);
            let accepted = heard(
                &mut fence,
                &[(1, 2 ^ (1 << bit), 12), (1, 2, 13), (1, 2, 14)],
            );
            assert_eq!(accepted, [false, true, true], "bit {bit}");
            assert_eq!(fence.generation(), 2, "bit {bit}");
            let successor = heard(&mut fence, &[(2, 3, 1), (1, 2, 15), (2, 3, 2)]);
            assert_eq!(successor, [true, false, true], "bit {bit}");
        }
    }

    #[test]
    fn a_flipped_bit_in_a_sequence_number_costs_at_most_the_next_message() {
        for bit in 0..u64::BITS {
            let mut fence = fence();
            heard(&mut fence, &[(1, 1, 10), (1, 1, 11)]);
            let accepted = heard(
                &mut fence,
                &[(1, 1, flipped(12, bit)), (1, 1, 13), (1, 1, 14)],
            );
            assert!(accepted[2], "bit {bit}");
            assert!(accepted[0] || accepted[1], "bit {bit}");
            heard(&mut fence, &[(1, 1, 15), (1, 1, 16)]);
            assert!(fence.counts.late <= 1, "bit {bit}: {:?}", fence.counts);
        }
    }

    #[test]
    fn a_flipped_bit_in_the_first_message_does_not_shut_its_writer_out() {
        for bit in 0..u32::BITS {
            let mut fence = fence();
            heard(&mut fence, &[(1, 1, 50), (2, 2 ^ (1 << bit), 1)]);
            assert_eq!(
                heard(&mut fence, &[(2, 2, 2), (1, 1, 51), (2, 2, 3)]),
                [true, false, true],
                "bit {bit}"
            );
        }
        for bit in 0..u64::BITS {
            let mut fence = fence();
            let first = [(1, 1, flipped(8, bit)), (1, 1, 9), (1, 1, 10), (1, 1, 14)];
            assert_eq!(heard(&mut fence, &first)[2..], [true, true], "bit {bit}");
            assert!(fence.counts.late >= 3, "bit {bit}");
        }
    }

    #[test]
    fn a_flipped_bit_of_a_replaced_writer_does_not_bring_it_back() {
        for bit in 0..u32::BITS {
            let mut fence = fence();
            heard(&mut fence, &[(1, 1, 50), (1, 1, 51), (2, 2, 1), (2, 2, 2)]);
            let messages = [(1, 1 ^ (1 << bit), 52), (2, 2, 3), (1, 1, 53), (2, 2, 4)];
            assert_eq!(
                heard(&mut fence, &messages),
                [false, true, false, true],
                "bit {bit}"
            );
        }
    }

    #[test]
    fn a_port_that_claimed_a_newer_generation_once_gives_way_to_the_newest() {
        let mut fence = fence();
        heard(&mut fence, &[(2, 2, 1), (2, 2, 2)]);
        // Of generation 1, joined late, with a flipped bit.
        let stray = heard(&mut fence, &[(1, 1 | (1 << 20), 52), (1, 1, 53), (2, 2, 3)]);
        assert_eq!(stray, [true, false, true]);
        assert_eq!(fence.generation(), 2);
    }

    #[test]
    fn a_process_that_opens_its_port_again_is_heard() {
        let mut fence = fence();
        let messages = [(1, 1, 50), (1, 1, 51), (2, 1, 1), (2, 1, 2)];
        assert_eq!(heard(&mut fence, &messages), [true; 4]);
    }

    #[test]
    fn what_was_overwritten_is_counted_within_one_generation() {
        let mut fence = fence();
        heard(
            &mut fence,
            &[(1, 1, 5), (1, 1, 6), (1, 1, 10), (3, 3, 40), (3, 3, 42)],
        );
        assert_eq!(fence.counts.late, 3 + 1);
    }

    #[test]
    fn the_same_message_twice_is_used_once() {
        let mut fence = fence();
        assert_eq!(heard(&mut fence, &[(1, 1, 1), (1, 1, 1)]), [true, false]);
        assert_eq!(fence.counts.fenced, 1);
    }

    #[test]
    fn an_older_message_that_comes_again_or_late_is_not_used() {
        for older in 1..=11 {
            let used = heard_in(&[10, 11, older, 12, 13]);
            assert_eq!(used, [true, true, false, true, true], "{older}");
        }
        assert_eq!(heard_in(&[10, 12, 11, 13]), [true, true, false, true]);
        let used = heard_in(&[10, 13, 11, 12, 13, 14]);
        assert_eq!(used, [true, true, false, false, false, true]);
    }

    #[test]
    fn a_flipped_bit_in_the_time_of_a_message_costs_nothing() {
        for bit in 0..u64::BITS {
            let mut fence = fence();
            let mut used = |seq, publish_ns| {
                let header = Header {
                    publish_ns,
                    ..header(1, seq)
                };
                fence.judge(1, &header, true) == Admission::Accept
            };
            assert!(used(10, 10) && used(11, flipped(11, bit)) && used(12, 12));
        }
    }

    #[test]
    fn strangers_are_rejected_and_move_nothing() {
        let mut fence = fence();
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
            assert_eq!(fence.judge(1, &stranger, true), Admission::Drop);
        }
        assert_eq!(fence.generation(), 0);
        assert_eq!(heard(&mut fence, &[(1, 1, 1)]), [true]);
        assert_eq!(fence.counts.rejected, 3);
    }

    #[test]
    fn nonsense_of_a_new_writer_still_silences_the_old_one() {
        let mut fence = fence();
        fence.judge(1, &header(1, 1), true);
        assert_eq!(fence.judge(2, &header(2, 1), false), Admission::Drop);
        assert_eq!(fence.judge(1, &header(1, 2), true), Admission::Drop);
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
