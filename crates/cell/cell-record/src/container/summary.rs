//! The summary at the end of a file: schemas, channels, statistics and an index of the chunks.

use mcap::records::op;

use super::chunk::{COMPRESSION, Summary};
use super::header::{MessageHeader, Schema};
use super::record::{Fields, record};

/// What a file holds so far.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) chunks: Vec<Summary>,
    /// Names; the number of a schema is its place here plus one.
    schemas: Vec<String>,
    /// All of them as records.
    schema_records: Vec<u8>,
    channel_records: Vec<u8>,
    /// Messages, by channel.
    counts: Vec<u64>,
    span_ns: Option<(u64, u64)>,
}

impl Contents {
    /// Number of a new channel, and the records that declare it.
    pub(super) fn declare(
        &mut self,
        topic: &str,
        encoding: &str,
        (name, schema_encoding, data): Schema<'_>,
    ) -> (u16, Vec<u8>) {
        let known = self.schemas.iter().position(|known| known == name);
        let schema = known.unwrap_or(self.schemas.len()) as u16 + 1;
        let mut records = Vec::new();
        if known.is_none() {
            self.schemas.push(name.to_owned());
            record(&mut records, op::SCHEMA, |out| {
                out.u16(schema);
                out.sized(name.as_bytes());
                out.sized(schema_encoding.as_bytes());
                out.sized(data.as_bytes());
            });
            self.schema_records.extend_from_slice(&records);
        }
        let (from, channel) = (records.len(), self.counts.len() as u16);
        record(&mut records, op::CHANNEL, |out| {
            out.u16(channel);
            out.u16(schema);
            out.sized(topic.as_bytes());
            out.sized(encoding.as_bytes());
            // No more to say of it.
            out.sized(&[]);
        });
        let declared = records.get(from..).unwrap_or_default();
        self.channel_records.extend_from_slice(declared);
        self.counts.push(0);
        (channel, records)
    }

    pub(super) fn count(&mut self, header: &MessageHeader) {
        if let Some(count) = self.counts.get_mut(usize::from(header.channel)) {
            *count += 1;
        }
        let (from, to) = self.span_ns.unwrap_or((header.time_ns, header.time_ns));
        self.span_ns = Some((from.min(header.time_ns), to.max(header.time_ns)));
    }

    fn write_statistics(&self, out: &mut Vec<u8>) {
        let (from, to) = self.span_ns.unwrap_or_default();
        out.u64(self.counts.iter().sum());
        out.u16(self.schemas.len() as u16);
        out.u32(self.counts.len() as u32);
        // Neither attachments nor metadata.
        out.u64(0);
        out.u32(self.chunks.len() as u32);
        out.u64(from);
        out.u64(to);
        let mut counts = Vec::new();
        for (channel, count) in (0..).zip(&self.counts) {
            counts.u16(channel);
            counts.u64(*count);
        }
        out.sized(&counts);
    }

    /// The group of records of `opcode`.
    fn write_group(&self, opcode: u8, out: &mut Vec<u8>) {
        match opcode {
            op::SCHEMA => out.extend_from_slice(&self.schema_records),
            op::CHANNEL => out.extend_from_slice(&self.channel_records),
            op::STATISTICS => record(out, opcode, |out| self.write_statistics(out)),
            _ => {
                for chunk in &self.chunks {
                    record(out, op::CHUNK_INDEX, |out| write_chunk(chunk, out));
                }
            }
        }
    }
}

fn write_chunk(chunk: &Summary, out: &mut Vec<u8>) {
    out.u64(chunk.span_ns.0);
    out.u64(chunk.span_ns.1);
    out.u64(chunk.offset);
    out.u64(chunk.length);
    let mut offsets = Vec::new();
    for (channel, offset) in &chunk.index_offsets {
        offsets.u16(*channel);
        offsets.u64(*offset);
    }
    out.sized(&offsets);
    out.u64(chunk.index_length);
    out.sized(COMPRESSION);
    out.u64(chunk.packed);
    out.u64(chunk.unpacked);
}

/// Appends summary, its offsets and the footer to `out`, which will lie at byte
/// `offset` of the file.
pub(super) fn write(contents: &Contents, offset: u64, out: &mut Vec<u8>) {
    let summary_at = out.len();
    let mut offsets = Vec::new();
    for opcode in [op::SCHEMA, op::CHANNEL, op::STATISTICS, op::CHUNK_INDEX] {
        let from = out.len();
        contents.write_group(opcode, out);
        let length = (out.len() - from) as u64;
        if length > 0 {
            record(&mut offsets, op::SUMMARY_OFFSET, |offsets| {
                offsets.push(opcode);
                offsets.u64(offset + from as u64);
                offsets.u64(length);
            });
        }
    }
    let offsets_at = out.len();
    out.extend_from_slice(&offsets);
    record(out, op::FOOTER, |out| {
        out.u64(offset + summary_at as u64);
        out.u64(offset + offsets_at as u64);
        out.u32(0);
    });
    // Of all from the summary up to the checksum itself, which is the last field.
    let sum_at = out.len() - size_of::<u32>();
    let sum = crc32fast::hash(out.get(summary_at..sum_at).unwrap_or_default());
    out.truncate(sum_at);
    out.u32(sum);
}
