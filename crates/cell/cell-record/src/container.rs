//! The container: MCAP, <https://mcap.dev/spec>, written by the library (ADR 0015).
//!
//! A process may be killed at any instant, and a disk may be full. The library writes a chunk
//! and its indexes in parts; here they become one write, so that a file ends with a whole chunk
//! nearly always, and nothing follows a write that failed.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use mcap::write::NoSeek;
use mcap::{Compression, McapError, WriteOptions, Writer};

pub(crate) use mcap::records::MessageHeader;

/// Bytes of a chunk before compression: a reader that looks at one moment
/// unpacks one or two of them.
const CHUNK_BYTES: usize = 768 << 10;

/// A schema: name, encoding, data.
pub(crate) type Schema<'a> = (&'a str, &'a str, &'a str);

/// A file that is being written. After a write that failed nothing more is
/// written: the file ends there.
pub(crate) struct Container {
    writer: Writer<NoSeek<Parts>>,
    written: Arc<AtomicU64>,
    /// Bytes of messages in the open chunk.
    open: usize,
}

impl Container {
    /// Starts a file with `profile`, by `library`.
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        profile: &str,
        library: &str,
    ) -> io::Result<Self> {
        let written = Arc::new(AtomicU64::new(0));
        let parts = Parts {
            out,
            bytes: Vec::new(),
            is_broken: false,
            written: Arc::clone(&written),
        };
        // Without seeking a chunk is compressed in memory: its header has its length.
        let options = WriteOptions::new()
            .profile(profile)
            .library(library)
            .compression(Some(Compression::Lz4))
            .chunk_size(None)
            .disable_seeking(true)
            .calculate_data_section_crc(false);
        let mut container = Self {
            writer: options.create(NoSeek::new(parts)).map_err(io_error)?,
            written,
            open: 0,
        };
        container.flush()?;
        Ok(container)
    }

    /// Bytes in the file.
    pub(crate) fn written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// Declares a channel called `topic` that speaks `encoding`; its number. A
    /// schema of the same name is the same.
    pub(crate) fn declare(
        &mut self,
        topic: &str,
        encoding: &str,
        (name, schema_encoding, data): Schema<'_>,
    ) -> io::Result<u16> {
        let schema = self
            .writer
            .add_schema(name, schema_encoding, data.as_bytes());
        let schema = schema.map_err(io_error)?;
        self.writer
            .add_channel(schema, topic, encoding, &BTreeMap::new())
            .map_err(io_error)
    }

    /// Adds a message.
    ///
    /// # Errors
    ///
    /// When a full chunk cannot be written.
    pub(crate) fn add(&mut self, header: &MessageHeader, data: &[u8]) -> io::Result<()> {
        self.writer
            .write_to_known_channel(header, data)
            .map_err(io_error)?;
        self.open += size_of::<MessageHeader>() + data.len();
        if self.open < CHUNK_BYTES {
            return Ok(());
        }
        self.flush()
    }

    /// Ends the chunk: all that was added is in the file.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.open = 0;
        self.writer.flush().map_err(io_error)
    }

    /// Ends the file; its size in bytes.
    ///
    /// # Errors
    ///
    /// When it cannot be written, or could not before.
    pub(crate) fn finish(&mut self) -> io::Result<u64> {
        self.writer.finish().map_err(io_error)?;
        Ok(self.written())
    }
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// Collects what the library writes until it flushes.
struct Parts {
    out: Box<dyn Write + Send>,
    bytes: Vec<u8>,
    is_broken: bool,
    written: Arc<AtomicU64>,
}

impl Write for Parts {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.is_broken {
            return Err(io::Error::other("it failed before"));
        }
        let done = self.out.write_all(&self.bytes);
        self.is_broken = done.is_err();
        self.written
            .fetch_add(self.bytes.len() as u64, Ordering::Relaxed);
        self.bytes.clear();
        done.and_then(|()| self.out.flush())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Memory {
        bytes: Arc<Mutex<Vec<u8>>>,
        room: Option<usize>,
    }

    impl Write for Memory {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut all = self.bytes.lock().unwrap();
            let room = self.room.map_or(bytes.len(), |room| room - all.len());
            if room == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let taken = bytes.len().min(room);
            all.extend_from_slice(&bytes[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn say(container: &mut Container, channel: u16, number: u32) -> io::Result<()> {
        let header = MessageHeader {
            channel_id: channel,
            sequence: number,
            log_time: u64::from(number) * 10,
            publish_time: u64::from(number) * 10 + 3,
        };
        let noise = |i: u32| (number.wrapping_mul(0x9e37_79b9) >> (i % 24)) as u8;
        let data: Vec<u8> = (0..400).map(noise).collect();
        container.add(&header, &data)
    }

    #[test]
    fn a_reader_of_the_format_finds_all_of_it() {
        let memory = Memory::default();
        let out = Box::new(memory.clone());
        let mut container = Container::new(out, "p", "l").unwrap();
        let schema = ("S", "jsonschema", "{}");
        let one = container.declare("one", "json", schema).unwrap();
        let two = container.declare("two", "json", schema).unwrap();
        for number in 0..5000 {
            say(
                &mut container,
                if number % 3 == 0 { two } else { one },
                number,
            )
            .unwrap();
        }
        let size = container.finish().unwrap();
        let bytes = memory.bytes.lock().unwrap().clone();
        assert_eq!(bytes.len() as u64, size);
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let stats = summary.stats.clone().unwrap();
        assert_eq!((stats.message_count, stats.schema_count), (5000, 1));
        assert_eq!(
            (stats.message_start_time, stats.message_end_time),
            (0, 49_990)
        );
        assert!(summary.chunk_indexes.len() > 1);
        let messages = mcap::MessageStream::new(&bytes).unwrap();
        let mut number = 0;
        for message in messages {
            let message = message.unwrap();
            assert_eq!(message.sequence, number);
            assert_eq!(
                message.channel.topic,
                if number % 3 == 0 { "two" } else { "one" }
            );
            assert_eq!(message.publish_time, u64::from(number) * 10 + 3);
            assert_eq!(message.data.len(), 400);
            number += 1;
        }
        assert_eq!(number, 5000);
        let found = |chunk| summary.read_message_indexes(&bytes, chunk).unwrap();
        let found = summary.chunk_indexes.iter().map(found);
        let entries = found.map(|of| of.values().map(Vec::len).sum::<usize>());
        assert_eq!(entries.sum::<usize>(), 5000);
    }

    #[test]
    fn nothing_follows_a_write_that_failed() {
        let memory = Memory {
            room: Some(2000),
            ..Memory::default()
        };
        let out = Box::new(memory.clone());
        let mut container = Container::new(out, "p", "l").unwrap();
        let one = container
            .declare("one", "json", ("S", "jsonschema", "{}"))
            .unwrap();
        say(&mut container, one, 0).unwrap();
        container.flush().unwrap();
        let whole = memory.bytes.lock().unwrap().len();
        for number in 1..100 {
            say(&mut container, one, number).unwrap();
        }
        assert!(container.flush().is_err() && whole < 2000);
        let cut = memory.bytes.lock().unwrap().clone();
        assert_eq!(cut.len(), 2000);
        say(&mut container, one, 100).unwrap();
        assert!(container.finish().is_err());
        assert_eq!(memory.bytes.lock().unwrap().len(), 2000);
    }
}
