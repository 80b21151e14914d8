//! The open chunk.

use mcap::records::op;

use super::header::MessageHeader;
use super::lz4::{BLOCK_BYTES, Frame};
use super::record::{Fields, record};

/// Bytes of the fields of a message.
const MESSAGE_BYTES: usize = 22;
/// Name of the compression.
pub(super) const COMPRESSION: &[u8] = b"lz4";

/// What the index at the end of the file says of a chunk.
pub(super) struct Summary {
    pub(super) span_ns: (u64, u64),
    pub(super) offset: u64,
    pub(super) length: u64,
    /// Where the index of each channel is in the file.
    pub(super) index_offsets: Vec<(u16, u64)>,
    pub(super) index_length: u64,
    pub(super) packed: u64,
    pub(super) unpacked: u64,
}

/// Records that are not in the file yet.
pub(super) struct Chunk {
    bytes: Vec<u8>,
    frame: Frame,
    /// Bytes that are in the frame.
    framed: usize,
    span_ns: (u64, u64),
    /// Time and place of every message, by channel.
    indexes: Vec<Vec<u8>>,
}

impl Chunk {
    pub(super) fn new() -> Self {
        let mut chunk = Self {
            bytes: Vec::new(),
            frame: Frame::default(),
            framed: 0,
            span_ns: (u64::MAX, 0),
            indexes: Vec::new(),
        };
        chunk.clear();
        chunk
    }

    /// Bytes before compression.
    pub(super) fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Adds a record that is no message.
    pub(super) fn put(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    pub(super) fn message(&mut self, header: &MessageHeader, data: &[u8]) {
        let at = self.bytes.len() as u64;
        let channel = usize::from(header.channel);
        if self.indexes.len() <= channel {
            self.indexes.resize_with(channel + 1, Vec::new);
        }
        if let Some(index) = self.indexes.get_mut(channel) {
            index.u64(header.time_ns);
            index.u64(at);
        }
        let (from, to) = self.span_ns;
        self.span_ns = (from.min(header.time_ns), to.max(header.time_ns));
        self.bytes.push(op::MESSAGE);
        self.bytes.u64((MESSAGE_BYTES + data.len()) as u64);
        self.bytes.u16(header.channel);
        self.bytes.u32(header.sequence);
        self.bytes.u64(header.time_ns);
        self.bytes.u64(header.publish_ns);
        self.bytes.extend_from_slice(data);
        self.compress(BLOCK_BYTES);
    }

    /// Appends chunk and indexes to `out`, the next byte of which is number
    /// `offset` of the file, and is empty afterwards.
    pub(super) fn close(&mut self, offset: u64, out: &mut Vec<u8>) -> Summary {
        self.compress(1);
        let base = out.len();
        // All of a chunk without messages is at 0.
        let span_ns = (self.span_ns.0.min(self.span_ns.1), self.span_ns.1);
        let unpacked = self.bytes.len() as u64;
        let packed = self.frame.end();
        record(out, op::CHUNK, |out| {
            out.u64(span_ns.0);
            out.u64(span_ns.1);
            out.u64(unpacked);
            out.u32(crc32fast::hash(&self.bytes));
            out.sized(COMPRESSION);
            out.u64(packed.len() as u64);
            out.extend_from_slice(packed);
        });
        let packed = packed.len() as u64;
        let length = (out.len() - base) as u64;
        let mut index_offsets = Vec::new();
        for (channel, index) in (0_u16..).zip(&self.indexes) {
            if index.is_empty() {
                continue;
            }
            index_offsets.push((channel, offset + (out.len() - base) as u64));
            record(out, op::MESSAGE_INDEX, |out| {
                out.u16(channel);
                out.sized(index);
            });
        }
        self.clear();
        Summary {
            span_ns,
            offset,
            length,
            index_offsets,
            index_length: (out.len() - base) as u64 - length,
            packed,
            unpacked,
        }
    }

    /// Puts what waits into the frame, in blocks, while there are `least` bytes.
    fn compress(&mut self, least: usize) {
        while let Some(rest) = self.bytes.get(self.framed..)
            && rest.len() >= least
        {
            let block = rest.get(..BLOCK_BYTES).unwrap_or(rest);
            self.frame.add(block);
            self.framed += block.len();
        }
    }

    fn clear(&mut self) {
        self.bytes.clear();
        self.frame.begin();
        self.framed = 0;
        self.span_ns = (u64::MAX, 0);
        self.indexes.iter_mut().for_each(Vec::clear);
    }
}
