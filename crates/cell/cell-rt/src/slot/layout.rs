//! Layout of a file of slots, and its check before the file is mapped.

use std::fs::OpenOptions;
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Marks a file of this layout (`RCSLOT02`).
pub(super) const MAGIC: u64 = u64::from_le_bytes(*b"RCSLOT02");
/// Words before the first slot: magic, capacity in bytes, number of slots.
pub(super) const FILE_HEADER: usize = 3;
/// Words before a slot's content: seq, length in bytes, checksum.
pub(super) const SLOT_HEADER: usize = 3;
/// Word of a slot with its checksum, or the mark of a slot that is being written.
pub(super) const CHECKSUM: usize = 2;
/// Largest record: a damaged length must not request more memory.
pub(super) const MAX_CAPACITY: usize = 64 * 1024 * 1024;
/// Largest number of slots.
// Physics keeps the requests of people in as many; a damaged number must not map more.
pub(super) const MAX_SLOTS: usize = 64;

/// A file before it is mapped.
pub(super) enum Found {
    Nothing,
    /// Of this layout and number of slots, with slots of this many bytes.
    Ours(usize),
    /// Of another layout, or cut off.
    Damaged,
}

impl Found {
    /// Reads the header of the file at `path`, which should have `slots` slots.
    pub(super) fn at(path: &Path, slots: usize) -> io::Result<Self> {
        // A link is not followed, and a FIFO not waited for.
        let flags = libc::O_NOFOLLOW | libc::O_NONBLOCK;
        let file = OpenOptions::new().read(true).custom_flags(flags).open(path);
        let mut file = match file {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::Nothing),
            Err(error) => return Err(error),
        };
        let length = file.metadata()?.len();
        if length == 0 {
            return Ok(Self::Nothing);
        }
        let mut header = [0; FILE_HEADER * 8];
        if file.read_exact(&mut header).is_err() {
            return Ok(Self::Damaged);
        }
        let (header, _) = header.as_chunks::<8>();
        let header = [0, 1, 2].map(|i| u64::from_le_bytes(header[i]));
        Ok(Self::of(header, length, slots))
    }

    /// What `header` says of a file of `length` bytes.
    pub(super) fn of([magic, capacity, found_slots]: [u64; 3], length: u64, slots: usize) -> Self {
        // Killed before the header was written, which is stored last.
        if magic == 0 {
            return Self::Nothing;
        }
        let capacity = usize::try_from(capacity).ok();
        let capacity = capacity.filter(|capacity| (1..=MAX_CAPACITY).contains(capacity));
        let is_whole = |capacity: &usize| length >= (words(*capacity, slots) * 8) as u64;
        let is_ours = magic == MAGIC && found_slots == slots as u64;
        let ours = capacity.filter(is_whole).filter(|_| is_ours);
        ours.map_or(Self::Damaged, Self::Ours)
    }
}

/// Words of a slot for `capacity` bytes.
pub(super) fn slot_words(capacity: usize) -> usize {
    SLOT_HEADER + capacity.div_ceil(8)
}

/// Words of a file of `slots` slots for `capacity` bytes.
pub(super) fn words(capacity: usize, slots: usize) -> usize {
    FILE_HEADER + slots * slot_words(capacity)
}

/// The stores that make `record` the content of a slot, each a word of the slot and its
/// value. A process may be killed after any of them.
// Not valid while it is being written: no record has a checksum above 32 bits. The mark is
// stored first, or an old checksum could cover a mixture, and the checksum last.
pub(super) fn stores(seq: u64, record: &[u8]) -> impl Iterator<Item = (usize, u64)> {
    let content = record.chunks(8).map(word_of);
    let content = [seq, record.len() as u64].into_iter().chain(content);
    let places = [0, 1].into_iter().chain(SLOT_HEADER..);
    let last = std::iter::once_with(move || (CHECKSUM, u64::from(checksum(seq, record))));
    std::iter::once((CHECKSUM, u64::MAX))
        .chain(places.zip(content))
        .chain(last)
}

/// Up to eight bytes as a word.
fn word_of(bytes: &[u8]) -> u64 {
    let mut word = [0; 8];
    word[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(word)
}

/// Checksum of a record and its `seq`.
pub(super) fn checksum(seq: u64, record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    for number in [MAGIC, seq, record.len() as u64] {
        hasher.update(&number.to_le_bytes());
    }
    hasher.update(record);
    hasher.finalize()
}
