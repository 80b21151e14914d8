//! Records as plain bytes: little-endian, with a length in front. A reader checks every
//! number before it relies on it: bytes may be damaged, or of another build.

/// Why a checkpoint is refused. The object is unchanged then.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// It starts with other bytes.
    #[error("these bytes are not the checkpoint of a {0}; give what its save wrote")]
    Kind(&'static str),
    /// It was written by a version with another format.
    #[error("the checkpoint has format {found}, {known} is known; start without a checkpoint")]
    Version {
        /// The format it has.
        found: u16,
        /// The format that can be read.
        known: u16,
    },
    /// It ends too early, continues too long, or contradicts itself.
    #[error("the checkpoint is damaged at byte {0}; start without a checkpoint")]
    Damaged(usize),
}

/// The number of entries that were restored from a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Carried {
    /// Nodes, and modifiers of nodes, whose state was restored.
    pub nodes: usize,
    /// Blackboard keys whose value was restored.
    pub keys: usize,
    /// Nodes, modifiers and keys of the checkpoint that no longer exist, are of another
    /// type now, or whose state has another form.
    pub lost: usize,
}

// Magic, version and length.
const HEADER_BYTES: usize = 10;

/// Starts a checkpoint; returns its position for [`close`].
pub(crate) fn open(record: &mut Vec<u8>, magic: [u8; 4], version: u16) -> usize {
    let start = record.len();
    record.extend_from_slice(&magic);
    record.extend_from_slice(&version.to_le_bytes());
    record.extend_from_slice(&[0; 4]);
    start
}

/// Ends the checkpoint that starts at `start`.
pub(crate) fn close(record: &mut [u8], start: usize) {
    let length = u32::try_from(record.len() - start).unwrap_or(u32::MAX);
    if let Some(place) = record.get_mut(start + HEADER_BYTES - 4..start + HEADER_BYTES) {
        place.copy_from_slice(&length.to_le_bytes());
    }
}

/// Appends what `write` writes with its length in front.
pub(crate) fn with_length(record: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    let start = record.len();
    record.extend_from_slice(&[0; 4]);
    write(record);
    let length = u32::try_from(record.len() - start - 4).unwrap_or(u32::MAX);
    if let Some(place) = record.get_mut(start..start + 4) {
        place.copy_from_slice(&length.to_le_bytes());
    }
}

/// Reads a checkpoint from its first byte to its last.
#[derive(Clone)]
pub(crate) struct Reader<'r> {
    all: &'r [u8],
    at: usize,
}

impl<'r> Reader<'r> {
    /// Checks the header.
    pub(crate) fn open(
        all: &'r [u8],
        magic: [u8; 4],
        version: u16,
        kind: &'static str,
    ) -> Result<Self, RecordError> {
        let mut reader = Self { all, at: 0 };
        if reader.bytes::<4>().ok() != Some(magic) {
            return Err(RecordError::Kind(kind));
        }
        let found = u16::from_le_bytes(reader.bytes()?);
        if found != version {
            return Err(RecordError::Version {
                found,
                known: version,
            });
        }
        if usize::try_from(reader.u32()?) != Ok(all.len()) {
            return Err(RecordError::Damaged(all.len()));
        }
        Ok(reader)
    }

    /// The bytes that follow.
    pub(crate) fn slice(&mut self, length: usize) -> Result<&'r [u8], RecordError> {
        let end = self.at.checked_add(length);
        let slice = end.and_then(|end| self.all.get(self.at..end));
        let slice = slice.ok_or(RecordError::Damaged(self.at))?;
        self.at += length;
        Ok(slice)
    }

    /// The bytes of [`with_length`].
    pub(crate) fn sized(&mut self) -> Result<&'r [u8], RecordError> {
        let length = self.u32()?;
        self.slice(usize::try_from(length).map_err(|_| self.damaged())?)
    }

    pub(crate) fn bytes<const N: usize>(&mut self) -> Result<[u8; N], RecordError> {
        let damaged = self.damaged();
        self.slice(N)?.try_into().map_err(|_| damaged)
    }

    pub(crate) fn u8(&mut self) -> Result<u8, RecordError> {
        Ok(u8::from_le_bytes(self.bytes()?))
    }

    pub(crate) fn u32(&mut self) -> Result<u32, RecordError> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    pub(crate) fn u64(&mut self) -> Result<u64, RecordError> {
        Ok(u64::from_le_bytes(self.bytes()?))
    }

    /// Refuses bytes that are left over.
    pub(crate) fn end(&self) -> Result<(), RecordError> {
        if self.at == self.all.len() {
            Ok(())
        } else {
            Err(self.damaged())
        }
    }

    pub(crate) fn damaged(&self) -> RecordError {
        RecordError::Damaged(self.at)
    }
}

// The published constants of FNV-1a with 64 bits. Records of older builds are found by them, so
// they are part of the format.
const HASH_START: u64 = 0xcbf2_9ce4_8422_2325;
const HASH_PRIME: u64 = 0x0000_0100_0000_01b3;

/// FNV-1a (Fowler, Noll, Vo) of a name, by which records know it.
pub(crate) fn name_hash(name: &str) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(HASH_PRIME);
    name.as_bytes().iter().fold(HASH_START, step)
}
