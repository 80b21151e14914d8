//! Finds the chunks of a file, also of one that was not closed.
//!
//! Our files are written until a kill or a full disk ends them, so the index at the end of a
//! file is not needed: the whole file is scanned by its record headers, and the first
//! incomplete record is its end. Any length in it may be damaged; each is checked before memory
//! is reserved or a position is computed.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cell_model::user_file;
use mcap::records::op;

use crate::PROFILE;
use crate::channel::Channel;
use crate::chunk::{self, Chunk, MAX_CHUNK_BYTES, Names};
use crate::entry::Entry;
use crate::epoch::Span;
use crate::error::RecordError;

/// Largest number of chunks of a file.
// Memory of a reader, which lists all chunks; at one chunk per second that is twelve days.
const MAX_CHUNKS: usize = 1 << 20;
/// Longest header (bytes).
// Ours has the profile and the name of the library, some 40 bytes.
const MAX_HEADER: u64 = 4096;

/// Contents of a file and their offsets.
#[derive(Clone, Debug)]
pub(crate) struct FileIndex {
    pub(crate) path: PathBuf,
    /// The open file: its content stays readable after the recorder has removed it.
    file: Arc<File>,
    pub(crate) chunks: Vec<Chunk>,
    pub(crate) names: Names,
    /// Reason why the file ends early; `None` for a file that was closed.
    pub(crate) cut: Option<String>,
}

impl FileIndex {
    /// Scans the file at `path`. A file that ends in the middle of a record ends before that
    /// record.
    pub(crate) fn scan(path: &Path) -> Result<Self, RecordError> {
        let io = |source| RecordError::io(path, source);
        let file = user_file::open_file(path).map_err(io)?;
        let size = file.metadata().map_err(io)?.len();
        let file = Arc::new(file);
        let mut scan = Scan {
            // Small reads: only the heads of records are needed, chunks are skipped.
            file: BufReader::with_capacity(4096, file.clone()),
            size,
            at: 0,
        };
        let mut index = Self {
            path: path.to_owned(),
            file,
            chunks: Vec::new(),
            names: Names::new(),
            cut: None,
        };
        scan.begin(path)?;
        // A cut file is not an error: everything before the cut can be shown.
        index.cut = index.go_through(&mut scan).err();
        index.read_epochs()?;
        Ok(index)
    }

    /// The messages of `chunk`, in the order of recording.
    pub(crate) fn entries(&self, chunk: &Chunk) -> Result<Vec<Entry>, RecordError> {
        chunk::read(&self.file, &self.path, chunk, &mut self.names.clone())
    }

    /// Reads the chunks that start an epoch. The first one declares the channels.
    fn read_epochs(&mut self) -> Result<(), RecordError> {
        let mut epoch = 0;
        for (number, chunk) in self.chunks.iter_mut().enumerate() {
            let begins = |id: &u16| self.names.get(id) == Some(&Some(Channel::Epoch));
            // The preamble: without it no channel of the file has a
            // name, so an error here is final.
            if number == 0 {
                let entries = chunk::read(&self.file, &self.path, chunk, &mut self.names)?;
                epoch = epoch_of(&entries).unwrap_or(0);
            // No other chunk is unpacked: that would read the whole file to open it.
            } else if chunk.channels.is_empty() || chunk.channels.iter().any(begins) {
                // One that cannot be read is reported when its messages are.
                let entries = chunk::read(&self.file, &self.path, chunk, &mut self.names);
                epoch = entries.ok().and_then(|e| epoch_of(&e)).unwrap_or(epoch);
            }
            chunk.epoch = epoch;
        }
        Ok(())
    }

    /// Time in each chunk.
    pub(crate) fn spans(&self) -> impl Iterator<Item = Span> {
        self.chunks.iter().map(|chunk| Span {
            epoch: chunk.epoch,
            from_ns: chunk.start_ns,
            to_ns: chunk.end_ns,
        })
    }

    fn go_through(&mut self, scan: &mut Scan) -> Result<(), String> {
        loop {
            let offset = scan.at;
            let (opcode, length) = scan.record()?;
            match opcode {
                op::CHUNK => {
                    // Checked by its length only; its content is checked when it is read.
                    let chunk = scan.chunk(offset, length)?;
                    self.chunks.push(chunk);
                    if self.chunks.len() > MAX_CHUNKS {
                        return Err(format!("more than {MAX_CHUNKS} chunks"));
                    }
                }
                // Indices of messages follow their chunk and tell which channels it has.
                op::MESSAGE_INDEX if length >= 6 => {
                    let id = scan.u16()?;
                    let used = scan.u32()? > 0;
                    if let Some(chunk) = self.chunks.last_mut().filter(|_| used) {
                        chunk.channels.push(id);
                    }
                }
                op::DATA_END | op::FOOTER => return Ok(()),
                _ => {}
            }
            scan.skip_to(offset + 9 + length)?;
        }
    }
}

/// The epoch that starts in `entries`.
fn epoch_of(entries: &[Entry]) -> Option<u32> {
    let begins = entries.iter().find(|e| e.channel == Channel::Epoch)?;
    let said: serde_json::Value = serde_json::from_slice(&begins.bytes).ok()?;
    u32::try_from(said.get("epoch")?.as_u64()?).ok()
}

struct Scan {
    file: BufReader<Arc<File>>,
    size: u64,
    at: u64,
}

impl Scan {
    fn begin(&mut self, path: &Path) -> Result<(), RecordError> {
        let refuse = |reason: &str| RecordError::NoRecording {
            path: path.to_owned(),
            reason: reason.to_owned(),
        };
        if self.size == 0 {
            return Err(refuse("it is empty"));
        }
        let magic = self.array::<8>().ok();
        if magic.is_none_or(|magic| magic != *mcap::MAGIC) {
            return Err(refuse("it is not an MCAP file"));
        }
        let header = self.header();
        let header = header.map_err(|_| refuse("it ends in its header"))?;
        if !header
            .windows(PROFILE.len())
            .any(|w| w == PROFILE.as_bytes())
        {
            return Err(refuse("an MCAP file, but not of a cell"));
        }
        Ok(())
    }

    fn header(&mut self) -> Result<Vec<u8>, String> {
        let (opcode, length) = self.record()?;
        if opcode != op::HEADER || length > MAX_HEADER {
            return Err("no header".to_owned());
        }
        let mut bytes = vec![0; length as usize];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    /// Opcode and length of the next record, which is complete.
    fn record(&mut self) -> Result<(u8, u64), String> {
        let [opcode] = self.array::<1>()?;
        let length = self.u64()?;
        // Here a cut file ends: the record is announced but not complete.
        if length > self.size.saturating_sub(self.at) {
            return Err(self.early());
        }
        Ok((opcode, length))
    }

    fn chunk(&mut self, offset: u64, length: u64) -> Result<Chunk, String> {
        let (start_ns, end_ns, unpacked) = (self.u64()?, self.u64()?, self.u64()?);
        // A damaged length must not reserve the memory of the machine.
        if unpacked > MAX_CHUNK_BYTES || length > MAX_CHUNK_BYTES {
            return Err(format!(
                "the chunk at byte {offset} claims {} bytes; at most {MAX_CHUNK_BYTES} are read",
                unpacked.max(length)
            ));
        }
        Ok(Chunk {
            offset,
            length: length + 9,
            start_ns,
            end_ns,
            channels: Vec::new(),
            epoch: 0,
        })
    }

    fn skip_to(&mut self, at: u64) -> Result<(), String> {
        // Relative, so that the buffered reader keeps its buffer over short distances.
        let by = at as i64 - self.at as i64;
        self.file
            .seek_relative(by)
            .map_err(|error| error.to_string())?;
        self.at = at;
        Ok(())
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), String> {
        self.file.read_exact(bytes).map_err(|_| self.early())?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    fn early(&self) -> String {
        format!(
            "it ends after {} bytes, in the middle of a record",
            self.size
        )
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        Ok(bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.array().map(u64::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    fn u16(&mut self) -> Result<u16, String> {
        self.array().map(u16::from_le_bytes)
    }
}
