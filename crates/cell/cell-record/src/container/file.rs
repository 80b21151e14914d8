//! The file around the chunks.

use std::io::{self, Write};

use mcap::records::op;

use super::chunk::Chunk;
use super::header::{MessageHeader, Schema};
use super::record::{Fields, record};
use super::summary::{self, Contents};

/// Bytes of a chunk before compression: a reader that looks at one moment
/// unpacks one or two of them.
const CHUNK_BYTES: usize = 768 << 10;

/// A file that is being written. After a write that failed nothing more is
/// written: the file ends there.
pub(crate) struct Container {
    out: Box<dyn Write + Send>,
    written: u64,
    is_broken: bool,
    chunk: Chunk,
    /// Bytes of the next write.
    buffer: Vec<u8>,
    contents: Contents,
}

impl Container {
    /// Starts a file with `profile`, by `library`.
    pub(crate) fn new(
        out: Box<dyn Write + Send>,
        profile: &str,
        library: &str,
    ) -> io::Result<Self> {
        let mut container = Self {
            out,
            written: 0,
            is_broken: false,
            chunk: Chunk::new(),
            buffer: Vec::new(),
            contents: Contents::default(),
        };
        container.buffer.extend_from_slice(mcap::MAGIC);
        record(&mut container.buffer, op::HEADER, |out| {
            out.sized(profile.as_bytes());
            out.sized(library.as_bytes());
        });
        container.write()?;
        Ok(container)
    }

    /// Bytes in the file.
    pub(crate) fn written(&self) -> u64 {
        self.written
    }

    /// Declares a channel called `topic` that speaks `encoding`; its number. A
    /// schema of the same name is the same.
    pub(crate) fn declare(&mut self, topic: &str, encoding: &str, schema: Schema<'_>) -> u16 {
        let (channel, records) = self.contents.declare(topic, encoding, schema);
        self.chunk.put(&records);
        channel
    }

    /// Adds a message.
    ///
    /// # Errors
    ///
    /// When a full chunk cannot be written.
    pub(crate) fn add(&mut self, header: &MessageHeader, data: &[u8]) -> io::Result<()> {
        self.chunk.message(header, data);
        self.contents.count(header);
        if self.chunk.len() < CHUNK_BYTES {
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
        if self.chunk.len() > 0 {
            let summary = self.chunk.close(self.written, &mut self.buffer);
            self.contents.chunks.push(summary);
            self.write()?;
        }
        self.out.flush()
    }

    /// Ends the file; its size in bytes.
    ///
    /// # Errors
    ///
    /// When it cannot be written, or could not before.
    pub(crate) fn finish(&mut self) -> io::Result<u64> {
        self.flush()?;
        record(&mut self.buffer, op::DATA_END, |out| out.u32(0));
        summary::write(&self.contents, self.written, &mut self.buffer);
        self.buffer.extend_from_slice(mcap::MAGIC);
        self.write()?;
        self.out.flush()?;
        Ok(self.written)
    }

    /// Writes the buffer.
    fn write(&mut self) -> io::Result<()> {
        if self.is_broken {
            return Err(io::Error::other("it failed before"));
        }
        let done = self.out.write_all(&self.buffer);
        self.is_broken = done.is_err();
        self.written += self.buffer.len() as u64;
        self.buffer.clear();
        done
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
            channel,
            sequence: number,
            time_ns: u64::from(number) * 10,
            publish_ns: u64::from(number) * 10 + 3,
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
        let one = container.declare("one", "json", schema);
        let two = container.declare("two", "json", schema);
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
        let one = container.declare("one", "json", ("S", "jsonschema", "{}"));
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
