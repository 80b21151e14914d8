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
//! claim; a message is used once, and none after a later one; one damaged header costs one
//! message, not the writer. The port id comes from the connection, not from the message.

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
mod tests;
