//! Unpacks one chunk.
//!
//! A chunk may be damaged anywhere. The library that reads it (`mcap` 0.26) trusts lengths in
//! some places, which fuzzing found; `check_records` refuses those before it is called.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::channel::Channel;
use crate::entry::Entry;
use crate::error::RecordError;

/// Limit of a chunk (bytes, packed and unpacked); ours are far smaller.
// Memory of a reader: a damaged length is refused instead of reserved.
pub(crate) const MAX_CHUNK_BYTES: u64 = 32 << 20;

/// Place and content of a chunk.
#[derive(Clone, Debug)]
pub(crate) struct Chunk {
    /// Of its record.
    pub(crate) offset: u64,
    /// Of its record, with opcode and length.
    pub(crate) length: u64,
    /// First time in it (ns).
    pub(crate) start_ns: u64,
    /// Last time in it (ns).
    pub(crate) end_ns: u64,
    /// Channels with messages in it; empty if unknown.
    pub(crate) channels: Vec<u16>,
    /// Generation of physics.
    pub(crate) epoch: u32,
}

/// Channels by their number in the file; `None` for unknown ones.
pub(crate) type Names = BTreeMap<u16, Option<Channel>>;

/// The messages of `chunk`, in the order of recording; channels found on the way are added to
/// `names`, and messages of unknown ones are left out.
pub(crate) fn read(
    file: &File,
    path: &Path,
    chunk: &Chunk,
    names: &mut Names,
) -> Result<Vec<Entry>, RecordError> {
    let io = |source| RecordError::io(path, source);
    let refuse = |reason: String| RecordError::format(path, chunk.offset, reason);
    // Checked here as well: the index may be of a file that has changed since.
    if chunk.length > MAX_CHUNK_BYTES {
        return Err(refuse(format!(
            "a chunk of {} bytes; at most {MAX_CHUNK_BYTES} are read",
            chunk.length
        )));
    }
    let mut packed = vec![0; chunk.length as usize];
    file.read_exact_at(&mut packed, chunk.offset).map_err(io)?;
    unpack(&packed, names).map_err(|error| refuse(format!("a chunk that cannot be read: {error}")))
}

/// Refuses a record that is longer than the uncompressed chunk around it: `mcap` 0.26 subtracts
/// without a check there, which ends the process or reads beyond the chunk.
fn check_records(packed: &[u8]) -> Result<(), String> {
    // Opcode, length, first and last time, uncompressed size, checksum.
    const COMPRESSION: usize = 1 + 8 + 8 + 8 + 8 + 4;
    let early = || "it ends in its header".to_owned();
    let number = |at: usize, bytes: usize| {
        let mut word = [0; 8];
        word[..bytes].copy_from_slice(packed.get(at..at + bytes)?);
        usize::try_from(u64::from_le_bytes(word)).ok()
    };
    if number(COMPRESSION, 4).ok_or_else(early)? != 0 {
        // The library checks the length of unpacked data itself.
        return Ok(());
    }
    let at = COMPRESSION + 4;
    let length = number(at, 8).ok_or_else(early)?;
    let mut records = packed[at + 8..].get(..length).ok_or_else(early)?;
    while !records.is_empty() {
        let cut = || "its last record ends in its header".to_owned();
        let (head, rest) = records.split_first_chunk::<9>().ok_or_else(cut)?;
        let [opcode, length @ ..] = *head;
        let length = u64::from_le_bytes(length);
        let after = usize::try_from(length).ok().and_then(|n| rest.get(n..));
        records = after.ok_or_else(|| {
            format!("its record of kind {opcode} and {length} bytes is longer than the chunk")
        })?;
    }
    Ok(())
}

fn unpack(packed: &[u8], names: &mut Names) -> Result<Vec<Entry>, String> {
    check_records(packed)?;
    let text = |error: mcap::McapError| error.to_string();
    // A chunk alone, without the magic of a file; checksums before any of its content is used.
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(MAX_CHUNK_BYTES as usize);
    let mut reader = LinearReader::new_with_options(options);
    let (mut rest, mut entries) = (packed, Vec::new());
    while let Some(event) = reader.next_event() {
        match event.map_err(text)? {
            // The library asks for bytes; at the end of the chunk it gets fewer and reports it.
            LinearReadEvent::ReadRequest(need) => {
                let (now, later) = rest.split_at(rest.len().min(need));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { opcode, data } => take(opcode, data, names, &mut entries)?,
        }
    }
    Ok(entries)
}

fn take(
    opcode: u8,
    data: &[u8],
    names: &mut Names,
    entries: &mut Vec<Entry>,
) -> Result<(), String> {
    // Other kinds of records are of no interest, and skipping them saves their parsing.
    if !matches!(
        opcode,
        mcap::records::op::CHANNEL | mcap::records::op::MESSAGE
    ) {
        return Ok(());
    }
    match mcap::read::parse_record(opcode, data).map_err(|error| error.to_string())? {
        Record::Channel(found) => {
            let channel = Channel::of_name(&found.topic);
            // Another encoding is a recording of another version:
            // reading on would give garbage.
            if let Some(known) = channel.filter(|c| c.message_encoding() != found.message_encoding)
            {
                return Err(format!(
                    "channel {:?} is {:?}, this version reads {:?}; replay it with the version that recorded it",
                    found.topic,
                    found.message_encoding,
                    known.message_encoding()
                ));
            }
            names.insert(found.id, channel);
        }
        Record::Message { header, data } => {
            // Leaving them out silently would look like a recording without them.
            let Some(channel) = names.get(&header.channel_id) else {
                return Err(format!(
                    "a message of channel {} that the first chunk does not declare; recordings that other tools wrote again are not read",
                    header.channel_id
                ));
            };
            // A channel of a newer version: the rest of the recording is still of use.
            if let Some(channel) = channel {
                entries.push(Entry::of(*channel, header, &data));
            }
        }
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_of_a_channel_nobody_declared_is_an_error_and_a_foreign_one_is_left_out() {
        let message: Vec<u8> = [9, 0].into_iter().chain([0; 20]).collect();
        let mut names = Names::new();
        let said = take(
            mcap::records::op::MESSAGE,
            &message,
            &mut names,
            &mut vec![],
        );
        assert!(said.unwrap_err().contains("channel 9"));
        names.insert(9, None);
        let mut entries = vec![];
        take(
            mcap::records::op::MESSAGE,
            &message,
            &mut names,
            &mut entries,
        )
        .unwrap();
        assert!(entries.is_empty());
    }

    /// A chunk of `length` bytes, not compressed, that claims so many bytes of records.
    fn chunk(length: usize, records: &[u8]) -> Vec<u8> {
        let mut chunk = vec![mcap::records::op::CHUNK];
        let body = 8 + 8 + 8 + 4 + 4 + 8 + records.len();
        chunk.extend((body as u64).to_le_bytes());
        chunk.extend([0; 16]);
        chunk.extend((length as u64).to_le_bytes());
        chunk.extend([0; 4 + 4]);
        chunk.extend((length as u64).to_le_bytes());
        chunk.extend(records);
        chunk
    }

    #[test]
    fn a_record_longer_than_its_chunk_is_an_error() {
        let record = |length: u64| {
            let mut record = vec![mcap::records::op::MESSAGE];
            record.extend(length.to_le_bytes());
            record.extend([0; 30]);
            record
        };
        // Found by fuzzing: mcap read past the chunk.
        for length in [31, 0x1fff_ffff, u64::MAX] {
            let said = unpack(&chunk(39, &record(length)), &mut Names::new()).unwrap_err();
            assert!(said.contains("longer than the chunk"), "{said}");
        }
        let said = unpack(&chunk(39, &record(30)), &mut Names::new()).unwrap_err();
        assert!(said.contains("channel 0"), "{said}");
        let said = unpack(&chunk(40, &record(30)), &mut Names::new()).unwrap_err();
        assert!(said.contains("ends"), "{said}");
        // Also found by fuzzing.
        for length in 1..9 {
            let said = unpack(&chunk(length, &record(30)), &mut Names::new()).unwrap_err();
            assert!(said.contains("ends in its header"), "{said}");
        }
        for end in 0..60 {
            unpack(&chunk(39, &record(30))[..end], &mut Names::new()).unwrap_err();
        }
    }
}
