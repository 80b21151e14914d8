//! Writes one file.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use cell_run::spec::RunSpec;
use serde_json::Value;

use crate::channel::Channel;
use crate::container::{Container, MessageHeader};
use crate::entry::Message;
use crate::error::RecordError;
use crate::storage::{Disk, Storage as _};
use crate::{PROFILE, solids};

/// First messages of every file.
///
/// Run, scene and epoch: with them a file can be read alone.
#[derive(Clone, Debug)]
pub struct Preamble {
    /// Arms of the cell.
    pub arms: u8,
    run: Vec<u8>,
    scene: Vec<u8>,
    update: Vec<u8>,
    epoch: u32,
}

impl Preamble {
    /// For recordings of `run`, whose page shows `scene`.
    pub fn new(run: &RunSpec, scene: &Value) -> Self {
        Self {
            arms: run.arms,
            // A run file and a scene are plain data: writing them cannot fail.
            run: serde_json::to_vec(run).unwrap_or_default(),
            scene: scene.to_string().into_bytes(),
            update: solids::scene_update(scene).to_string().into_bytes(),
            epoch: 0,
        }
    }

    /// Sets the epoch of files started from now on, a generation of physics.
    pub fn set_epoch(&mut self, epoch: u32) {
        self.epoch = epoch;
    }
}

/// Writes one MCAP file: lz4 in chunks, an index at the end. Flushed messages are readable even
/// if nothing follows.
pub struct RecordingWriter {
    container: Container,
    ids: BTreeMap<Channel, u16>,
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
        let library = concat!("cell-record ", env!("CARGO_PKG_VERSION"));
        let container = Container::new(out, PROFILE, library);
        let mut recording = Self {
            container: container.map_err(RecordError::write)?,
            ids: BTreeMap::new(),
            preamble: Some(preamble.clone()),
            packed: Vec::new(),
        };
        // All channels at once, before any message: the first chunk declares every name.
        for channel in Channel::all(preamble.arms) {
            recording.declare(channel);
        }
        Ok(recording)
    }

    /// Adds a message; its struct is packed here.
    ///
    /// # Errors
    ///
    /// When the disk does not take it: the file ends with what was flushed.
    pub fn add(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        // The buffer is taken and put back, so that packing allocates only while it grows.
        let mut buffer = std::mem::take(&mut self.packed);
        let added = self.add_packed(&message.packed(&mut buffer));
        self.packed = buffer;
        added
    }

    /// Adds a message whose struct was packed by [`crate::pack()`].
    ///
    /// # Errors
    ///
    /// As [`Self::add`].
    pub fn add_packed(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        self.begin_at(message.time_ns)?;
        // An epoch starts a chunk: readers search only chunks with an epoch for it, and take it
        // for the whole chunk.
        if message.channel == Channel::Epoch {
            self.flush()?;
        }
        self.put(message)
    }

    /// Writes the first messages of the file under simulated time `time_ns`, if that was not
    /// done.
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

    /// Starts `epoch` at simulated time `time_ns`: all later messages are of it.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn begin_epoch(&mut self, epoch: u32, time_ns: u64) -> Result<(), RecordError> {
        // Nothing is written yet: the preamble names the epoch.
        if let Some(preamble) = &mut self.preamble {
            preamble.epoch = epoch;
            return Ok(());
        }
        self.flush()?;
        self.put_epoch(epoch, time_ns)
    }

    /// Ends the chunk: all added messages can be read from now on.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        // The first chunk has to hold the first messages of the file.
        if self.preamble.is_some() {
            return Ok(());
        }
        self.container.flush().map_err(RecordError::write)
    }

    /// Bytes written to the file.
    pub fn bytes(&self) -> u64 {
        self.container.written()
    }

    /// Writes the index and closes the file; its size in bytes.
    ///
    /// # Errors
    ///
    /// When the disk does not take it.
    pub fn finish(mut self) -> Result<u64, RecordError> {
        // Also a file without messages gets its preamble, and is a valid recording.
        self.begin_at(0)?;
        self.container.finish().map_err(RecordError::write)
    }

    /// Run, scene and epoch, in their own chunk: with them on the disk, the rest can be read.
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
        self.put_epoch(preamble.epoch, time_ns)?;
        self.flush()
    }

    fn put_epoch(&mut self, epoch: u32, time_ns: u64) -> Result<(), RecordError> {
        let said = serde_json::json!({ "epoch": epoch }).to_string();
        self.put(&Message {
            channel: Channel::Epoch,
            time_ns,
            publish_ns: time_ns,
            seq: 0,
            bytes: said.as_bytes(),
        })
    }

    fn put(&mut self, message: &Message<'_>) -> Result<(), RecordError> {
        let known = self.ids.get(&message.channel).copied();
        let header = MessageHeader {
            channel: known.unwrap_or_else(|| self.declare(message.channel)),
            // The format has 32 bits for it; all of it is in the message.
            sequence: message.seq as u32,
            time_ns: message.time_ns,
            publish_ns: message.publish_ns,
        };
        let added = self.container.add(&header, message.bytes);
        added.map_err(RecordError::write)
    }

    fn declare(&mut self, channel: Channel) -> u16 {
        let schema = channel.schema();
        let schema = (schema.name, schema.encoding, &schema.data[..]);
        let encoding = channel.message_encoding();
        let id = self.container.declare(&channel.name(), encoding, schema);
        self.ids.insert(channel, id);
        id
    }
}
