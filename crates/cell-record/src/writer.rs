//! Writes one file.

use std::collections::BTreeMap;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::run_spec::RunSpec;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions};
use serde_json::Value;

use crate::channel::Channel;
use crate::entry::Message;
use crate::error::RecordError;
use crate::storage::{Disk, Storage as _};
use crate::{PROFILE, foxglove};

/// Bytes of a chunk before compression: a reader that looks at one moment
/// unpacks one or two of them.
const CHUNK_BYTES: u64 = 768 << 10;
const BUFFER_BYTES: usize = 64 << 10;

/// What every file begins with.
#[derive(Clone, Debug)]
pub struct Preamble {
    /// Arms of the cell.
    pub arms: u8,
    run: Vec<u8>,
    scene: Vec<u8>,
    update: Vec<u8>,
}

impl Preamble {
    /// For recordings of `run`, whose page shows `scene`.
    pub fn new(run: &RunSpec, scene: &Value) -> Self {
        Self {
            arms: run.arms,
            run: serde_json::to_vec(run).unwrap_or_default(),
            scene: scene.to_string().into_bytes(),
            update: foxglove::scene_update(scene).to_string().into_bytes(),
        }
    }
}

/// Writes one MCAP file: lz4 in chunks, an index at the end. What was flushed is
/// readable even when nothing follows.
pub struct RecordingWriter {
    writer: mcap::Writer<Counted>,
    ids: BTreeMap<Channel, u16>,
    written: Arc<AtomicU64>,
    preamble: Option<Preamble>,
    packed: Vec<u8>,
}

impl RecordingWriter {
    /// Creates the file at `path`, which must not be there yet.
    ///
    /// # Errors
    ///
    /// When it is there, or cannot be written.
    pub fn create(path: &Path, preamble: &Preamble) -> Result<Self, RecordError> {
        let file = Disk
            .create(path)
            .map_err(|source| RecordError::io(path, source))?;
        Self::new(file, preamble)
    }

    /// Writes to `out`.
    ///
    /// # Errors
    ///
    /// When it cannot be written.
    pub fn new(out: Box<dyn Write + Send>, preamble: &Preamble) -> Result<Self, RecordError> {
        let written = Arc::new(AtomicU64::new(0));
        let out = Counted {
            out: BufWriter::with_capacity(BUFFER_BYTES, out),
            written: written.clone(),
        };
        let options = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .profile(PROFILE)
            .library(concat!("cell-record ", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(CHUNK_BYTES))
            .calculate_data_section_crc(false)
            .disable_seeking(true);
        let writer = options.create(out).map_err(RecordError::write)?;
        let mut recording = Self {
            writer,
            ids: BTreeMap::new(),
            written,
            preamble: Some(preamble.clone()),
            packed: Vec::new(),
        };
        for channel in Channel::all(preamble.arms) {
            recording.declare(channel)?;
        }
        Ok(recording)
    }

    /// Adds a message.
    ///
    /// # Errors
    ///
    /// When the disk does not take it: the file ends with what was flushed.
    pub fn add(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        let mut buffer = std::mem::take(&mut self.packed);
        let added = self.add_packed(&message.packed(&mut buffer));
        self.packed = buffer;
        added
    }

    /// Adds a message whose struct has been through [`crate::pack()`].
    ///
    /// # Errors
    ///
    /// As [`Self::add`].
    pub fn add_packed(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        self.begin_at(message.time_ns)?;
        self.put(message)
    }

    /// Writes what every file begins with, under simulated time `time_ns`, if
    /// that is not there yet.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn begin_at(&mut self, time_ns: u64) -> Result<(), RecordError> {
        match self.preamble.take() {
            Some(preamble) => self.begin(&preamble, time_ns),
            None => Ok(()),
        }
    }

    /// Ends the chunk: all that was added is readable from now on.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        // The first chunk has to hold what every file begins with.
        if self.preamble.is_some() {
            return Ok(());
        }
        self.writer.flush().map_err(RecordError::write)
    }

    /// Bytes written to the file.
    pub fn bytes(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }

    /// Writes the index and closes the file; its size in bytes.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn finish(mut self) -> Result<u64, RecordError> {
        self.begin_at(0)?;
        self.writer.finish().map_err(RecordError::write)?;
        Ok(self.bytes())
    }

    /// Run and scene, in a chunk of their own: with them on the disk, the rest
    /// can be read.
    fn begin(&mut self, preamble: &Preamble, time_ns: u64) -> Result<(), RecordError> {
        for (channel, bytes) in [
            (Channel::Run, &preamble.run),
            (Channel::Scene, &preamble.scene),
            (Channel::SceneUpdate, &preamble.update),
        ] {
            self.put(&Message {
                channel,
                time_ns,
                publish_ns: time_ns,
                seq: 0,
                bytes,
            })?;
        }
        self.flush()
    }

    fn put(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        let channel_id = match self.ids.get(&message.channel) {
            Some(id) => *id,
            None => self.declare(message.channel)?,
        };
        let header = MessageHeader {
            channel_id,
            // The format has 32 bits for it; all of it is in the message.
            sequence: message.seq as u32,
            log_time: message.time_ns,
            publish_time: message.publish_ns,
        };
        let written = self.writer.write_to_known_channel(&header, message.bytes);
        written.map_err(RecordError::write)
    }

    fn declare(&mut self, channel: Channel) -> Result<u16, RecordError> {
        let schema = channel.schema();
        let id = self
            .writer
            .add_schema(schema.name, schema.encoding, schema.data.as_bytes())
            .and_then(|schema| {
                let encoding = channel.message_encoding();
                self.writer
                    .add_channel(schema, &channel.name(), encoding, &BTreeMap::new())
            })
            .map_err(RecordError::write)?;
        self.ids.insert(channel, id);
        Ok(id)
    }
}

/// Counts what goes through. The position is all that is asked of a seek.
struct Counted {
    out: BufWriter<Box<dyn Write + Send>>,
    written: Arc<AtomicU64>,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.written.fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Seek for Counted {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match to {
            SeekFrom::Current(0) => Ok(self.written.load(Ordering::Relaxed)),
            _ => Err(io::ErrorKind::Unsupported.into()),
        }
    }
}
