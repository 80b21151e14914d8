//! Unpacks one chunk.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::channel::Channel;
use crate::entry::Entry;
use crate::error::RecordError;

/// No chunk of ours comes near this (bytes, packed and unpacked).
pub(crate) const MAX_CHUNK_BYTES: u64 = 32 << 20;

/// Where a chunk is and what is in it.
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
    /// Channels that have messages in it; empty where that is not known.
    pub(crate) channels: Vec<u16>,
}

/// Channels by their number in the file; `None` for those we do not know.
pub(crate) type Names = BTreeMap<u16, Option<Channel>>;

/// The messages of `chunk`, in the order they were recorded; channels met on the
/// way are added to `names`, and messages of unknown ones left out.
pub(crate) fn read(
    file: &mut File,
    path: &Path,
    chunk: &Chunk,
    names: &mut Names,
) -> Result<Vec<Entry>, RecordError> {
    let io = |source| RecordError::io(path, source);
    let refuse = |reason: String| RecordError::format(path, chunk.offset, reason);
    if chunk.length > MAX_CHUNK_BYTES {
        return Err(refuse(format!(
            "a chunk of {} bytes; at most {MAX_CHUNK_BYTES} are read",
            chunk.length
        )));
    }
    let mut packed = vec![0; chunk.length as usize];
    file.seek(SeekFrom::Start(chunk.offset)).map_err(io)?;
    file.read_exact(&mut packed).map_err(io)?;
    unpack(&packed, names).map_err(|error| refuse(format!("a chunk that cannot be read: {error}")))
}

fn unpack(packed: &[u8], names: &mut Names) -> Result<Vec<Entry>, String> {
    let text = |error: mcap::McapError| error.to_string();
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(MAX_CHUNK_BYTES as usize);
    let mut reader = LinearReader::new_with_options(options);
    let (mut rest, mut entries) = (packed, Vec::new());
    while let Some(event) = reader.next_event() {
        match event.map_err(text)? {
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
    if !matches!(
        opcode,
        mcap::records::op::CHANNEL | mcap::records::op::MESSAGE
    ) {
        return Ok(());
    }
    match mcap::read::parse_record(opcode, data).map_err(|error| error.to_string())? {
        Record::Channel(found) => {
            let channel = Channel::of_name(&found.topic);
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
            // Silence about them would look like a recording without them.
            let Some(channel) = names.get(&header.channel_id) else {
                return Err(format!(
                    "a message of channel {} that the first chunk does not declare; recordings that other tools wrote again are not read",
                    header.channel_id
                ));
            };
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
}
