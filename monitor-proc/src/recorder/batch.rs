//! Messages of one reading of the taps, sorted by their time of publication. A message beside
//! its inputs also compresses better.

use cell_record::{Channel, Message, gap, pack};
use ipc_types::{Header, TICK_NS};

/// A message and its place among the bytes.
#[derive(Clone, Copy)]
struct Item {
    channel: Channel,
    time_ns: u64,
    publish_ns: u64,
    seq: u64,
    from: usize,
    to: usize,
}

/// Messages of one topic, in the order they were sent.
#[derive(Default)]
struct Source {
    items: Vec<Item>,
    /// The first that was not passed on yet.
    next: usize,
}

/// Packed messages of several topics.
pub(super) struct Batch {
    bytes: Vec<u8>,
    sources: Vec<Source>,
}

impl Batch {
    /// For topics numbered below `sources`.
    pub(super) fn new(sources: usize) -> Self {
        Self {
            bytes: Vec::new(),
            sources: (0..sources).map(|_| Source::default()).collect(),
        }
    }

    /// Adds a struct of topic `source`: its `header` and its `bytes`.
    pub(super) fn put(&mut self, source: usize, channel: Channel, header: &Header, bytes: &[u8]) {
        let from = self.bytes.len();
        // Packed here, once, for both the ring and the file.
        pack(bytes, &mut self.bytes);
        self.add(source, channel, header, from);
    }

    /// Adds JSON from `write` about a message of topic `source`.
    pub(super) fn put_json(
        &mut self,
        source: usize,
        channel: Channel,
        header: &Header,
        write: impl FnOnce(&mut Vec<u8>),
    ) {
        let from = self.bytes.len();
        write(&mut self.bytes);
        // Without a number: JSON of a message is not the message, and has no gaps.
        let unnumbered = Header { seq: 0, ..*header };
        self.add(source, channel, &unnumbered, from);
    }

    /// Adds that the state with `header` is the first of `epoch`.
    pub(super) fn put_epoch(&mut self, source: usize, header: &Header, epoch: u32) {
        let from = self.bytes.len();
        let begins = Header {
            seq: u64::from(epoch),
            ..*header
        };
        self.add(source, Channel::Epoch, &begins, from);
    }

    /// Adds that `count` messages of `channel` were missed, the last of them before number
    /// `before_seq`.
    pub(super) fn put_gap(&mut self, source: usize, channel: Channel, count: u64, before_seq: u64) {
        let from = self.bytes.len();
        let line = gap(channel, count, before_seq, "late");
        self.bytes.extend_from_slice(&line);
        let to = self.bytes.len();
        let Some(source) = self.sources.get_mut(source) else {
            return;
        };
        // The time of the message before the gap, as a gap itself has none.
        let last = source.items.last();
        let (time_ns, publish_ns) = last.map_or((0, 0), |item| (item.time_ns, item.publish_ns));
        source.items.push(Item {
            channel: Channel::Gaps,
            time_ns,
            publish_ns,
            seq: 0,
            from,
            to,
        });
    }

    /// Passes on everything in the order of publication; messages of one topic never overtake
    /// each other. The batch is empty afterwards.
    pub(super) fn hand_over(&mut self, mut to: impl FnMut(&Message<'_>)) {
        // Few topics, so the earliest is searched each time; each topic is sorted already.
        let earliest = |sources: &mut Vec<Source>| {
            let waiting = sources.iter_mut().filter_map(|source| {
                let sent_ns = source.items.get(source.next)?.publish_ns;
                Some((sent_ns, &mut source.next, &source.items))
            });
            let (_, next, items) = waiting.min_by_key(|(sent_ns, ..)| *sent_ns)?;
            let item = items.get(*next).copied();
            *next += 1;
            item
        };
        while let Some(item) = earliest(&mut self.sources) {
            to(&Message {
                channel: item.channel,
                time_ns: item.time_ns,
                publish_ns: item.publish_ns,
                seq: item.seq,
                bytes: self.bytes.get(item.from..item.to).unwrap_or_default(),
            });
        }
        // Buffers are kept, so that they grow only at the start.
        self.bytes.clear();
        for source in &mut self.sources {
            source.items.clear();
            source.next = 0;
        }
    }

    fn add(&mut self, source: usize, channel: Channel, header: &Header, from: usize) {
        let to = self.bytes.len();
        if let Some(source) = self.sources.get_mut(source) {
            source.items.push(Item {
                channel,
                time_ns: header.tick * TICK_NS,
                publish_ns: header.publish_ns,
                seq: header.seq,
                from,
                to,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn header(publish_ns: u64, tick: u64) -> Header {
        let mut header = Header::zeroed();
        (header.publish_ns, header.tick) = (publish_ns, tick);
        header
    }

    fn sent(batch: &mut Batch) -> Vec<(Channel, u64)> {
        let mut sent = Vec::new();
        batch.hand_over(|message| sent.push((message.channel, message.time_ns / TICK_NS)));
        sent
    }

    #[test]
    fn topics_are_merged_and_none_overtakes_itself() {
        let (world, command) = (Channel::World, Channel::Command(0));
        let mut batch = Batch::new(2);
        // The scene is reset after tick 8.
        for (sent, tick) in [(10, 7), (20, 8), (30, 0)] {
            batch.put(0, world, &header(sent, tick), &[1; 16]);
            batch.put(1, command, &header(sent + 5, tick), &[2; 8]);
        }
        let order = [(world, 7), (command, 7), (world, 8), (command, 8)];
        let order = [&order[..], &[(world, 0), (command, 0)]].concat();
        assert_eq!(sent(&mut batch), order);
        assert_eq!(sent(&mut batch), []);
        // A clock that went back delays, and changes no order.
        batch.put(0, world, &header(40, 1), &[]);
        batch.put(0, world, &header(3, 2), &[]);
        batch.put(1, command, &header(4, 1), &[]);
        assert_eq!(sent(&mut batch), [(command, 1), (world, 1), (world, 2)]);
    }

    #[test]
    fn bytes_are_packed_and_a_gap_follows_what_came_before_it() {
        let mut batch = Batch::new(1);
        batch.put(0, Channel::Decision, &header(1, 5), &[3; 24]);
        batch.put_json(0, Channel::FoxgloveLog, &header(1, 5), |out| {
            out.extend_from_slice(b"{}");
        });
        batch.put_gap(0, Channel::Decision, 4, 9);
        let mut bytes = Vec::new();
        batch.hand_over(|message| bytes.push((message.channel, message.bytes.to_vec())));
        assert_eq!(cell_record::unpack(&bytes[0].1), Some(vec![3; 24]));
        assert_eq!(bytes[1], (Channel::FoxgloveLog, b"{}".to_vec()));
        assert_eq!(bytes[2].0, Channel::Gaps);
        let gap: serde_json::Value = serde_json::from_slice(&bytes[2].1).unwrap();
        assert_eq!(
            (&gap["channel"], &gap["count"]),
            (&"decision".into(), &4.into())
        );
    }
}
