//! Records that survive `kill -9` at any instant.
//!
//! Two slots or more in a mapped file, written in turn, each with a checksum over
//! everything in it. While one is being written the others are whole.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering, fence};

use crate::crc::crc32;
use crate::shared::SharedWords;

/// Marks a file of this layout (`RCSLOT02`).
const MAGIC: u64 = u64::from_le_bytes(*b"RCSLOT02");
/// Words before the first slot: magic, capacity in bytes, number of slots.
const FILE_HEADER: usize = 3;
/// Words before a slot's content: seq, length in bytes, checksum.
const SLOT_HEADER: usize = 3;
/// Largest record.
const MAX_CAPACITY: usize = 64 * 1024 * 1024;
/// Most slots.
const MAX_SLOTS: usize = 64;

/// The file of slots. Writing allocates nothing and makes no system call.
#[derive(Debug)]
pub struct SlotFile {
    memory: SharedWords,
    capacity: usize,
    slots: usize,
    next: usize,
    damaged: bool,
}

impl SlotFile {
    /// Opens or creates the file at `path` (on tmpfs) for records of up to
    /// `capacity` bytes. A file of another layout or capacity is initialised again:
    /// what is in it is not ours to read.
    pub fn open(path: &Path, capacity: usize) -> io::Result<Self> {
        Self::with_slots(path, capacity, 2)
    }

    /// As [`Self::open`], with room for the newest `slots` records (2 to 64).
    pub fn with_slots(path: &Path, capacity: usize, slots: usize) -> io::Result<Self> {
        let fits = (1..=MAX_CAPACITY).contains(&capacity) && (2..=MAX_SLOTS).contains(&slots);
        if !fits {
            let text = format!(
                "{slots} slots of {capacity} bytes; 2 to {MAX_SLOTS} of 1 to {MAX_CAPACITY} bytes \
                 are possible"
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        let words = FILE_HEADER + slots * (SLOT_HEADER + capacity.div_ceil(8));
        let memory = SharedWords::open(path, words)?;
        let mut this = Self {
            memory,
            capacity,
            slots,
            next: 0,
            damaged: false,
        };
        let wanted = [MAGIC, capacity as u64, slots as u64];
        let found = [0, 1, 2].map(|i| this.memory.words()[i].load(Ordering::Relaxed));
        this.damaged = if found == wanted {
            (0..slots).any(|slot| this.is_damaged_slot(slot))
        } else {
            found[0] != 0
        };
        if found != wanted {
            this.clear();
            for (word, value) in this.memory.words().iter().zip(wanted).rev() {
                word.store(value, Ordering::Release);
            }
        }
        // The oldest slot is the one to write next.
        this.next = match this.newest_slot() {
            Some((slot, _)) => (slot + 1) % slots,
            None => 0,
        };
        Ok(this)
    }

    /// Whether the file was damaged, or of another layout, when it was opened: records
    /// of it are lost. One that was being written when its writer was killed does not
    /// count.
    pub fn was_damaged(&self) -> bool {
        self.damaged
    }

    /// Neither empty, nor being written, nor whole.
    fn is_damaged_slot(&self, slot: usize) -> bool {
        let stored = self.slot(slot)[2].load(Ordering::Acquire);
        stored != 0 && stored != u64::MAX && self.read(slot).is_none()
    }

    /// Largest record in bytes.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Writes a record. `seq` says which record is the newest and must grow.
    /// False, and nothing is written, when the record is too long.
    pub fn write(&mut self, seq: u64, record: &[u8]) -> bool {
        if record.len() > self.capacity {
            return false;
        }
        let slot = self.slot(self.next);
        // Not valid while it is being written: no record has a checksum above
        // 32 bits.
        slot[2].store(u64::MAX, Ordering::Relaxed);
        fence(Ordering::SeqCst);
        slot[0].store(seq, Ordering::Relaxed);
        slot[1].store(record.len() as u64, Ordering::Relaxed);
        for (word, bytes) in slot[SLOT_HEADER..].iter().zip(record.chunks(8)) {
            word.store(word_of(bytes), Ordering::Relaxed);
        }
        fence(Ordering::SeqCst);
        slot[2].store(u64::from(checksum(seq, record)), Ordering::Release);
        self.next = (self.next + 1) % self.slots;
        true
    }

    /// The newest whole record with its `seq`.
    pub fn newest(&self) -> Option<(u64, Vec<u8>)> {
        let (slot, seq) = self.newest_slot()?;
        self.read(slot).filter(|(read_seq, _)| *read_seq == seq)
    }

    /// All whole records with their `seq`, the newest first.
    pub fn all(&self) -> Vec<(u64, Vec<u8>)> {
        let slots = 0..self.slots;
        let mut all: Vec<_> = slots.filter_map(|slot| self.read(slot)).collect();
        all.sort_by_key(|(seq, _)| core::cmp::Reverse(*seq));
        all
    }

    /// Forgets all records.
    pub fn clear(&mut self) {
        for slot in 0..self.slots {
            self.slot(slot)[2].store(u64::MAX, Ordering::Release);
        }
    }

    fn newest_slot(&self) -> Option<(usize, u64)> {
        let seq = |slot| Some((slot, self.read(slot)?.0));
        let seqs = (0..self.slots).filter_map(seq);
        seqs.max_by_key(|(_, seq)| *seq)
    }

    fn slot(&self, index: usize) -> &[AtomicU64] {
        let length = SLOT_HEADER + self.capacity.div_ceil(8);
        &self.memory.words()[FILE_HEADER + index * length..][..length]
    }

    fn read(&self, index: usize) -> Option<(u64, Vec<u8>)> {
        let slot = self.slot(index);
        let stored = slot[2].load(Ordering::Acquire);
        let seq = slot[0].load(Ordering::Relaxed);
        let length = usize::try_from(slot[1].load(Ordering::Relaxed)).ok()?;
        if length > self.capacity {
            return None;
        }
        let mut record = Vec::with_capacity(length.next_multiple_of(8));
        for word in &slot[SLOT_HEADER..SLOT_HEADER + length.div_ceil(8)] {
            record.extend_from_slice(&word.load(Ordering::Relaxed).to_le_bytes());
        }
        record.truncate(length);
        (stored == u64::from(checksum(seq, &record))).then_some((seq, record))
    }
}

fn word_of(bytes: &[u8]) -> u64 {
    let mut word = [0; 8];
    word[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(word)
}

fn checksum(seq: u64, record: &[u8]) -> u32 {
    let start = crc32(crc32(0, &MAGIC.to_le_bytes()), &seq.to_le_bytes());
    crc32(crc32(start, &(record.len() as u64).to_le_bytes()), record)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    struct TestFile(PathBuf);

    impl TestFile {
        fn new(name: &str) -> Self {
            let file = format!("cell-rt-slot-{name}-{}", std::process::id());
            Self(std::env::temp_dir().join(file))
        }
    }

    impl Drop for TestFile {
        fn drop(&mut self) {
            std::fs::remove_file(&self.0).unwrap();
        }
    }

    #[test]
    fn the_newest_record_is_found_after_reopening() {
        let place = TestFile::new("newest");
        let mut file = SlotFile::open(&place.0, 100).unwrap();
        assert_eq!(file.newest(), None);
        for seq in 1..=7 {
            assert!(file.write(seq, format!("record {seq}").as_bytes()));
        }
        assert!(!file.write(8, &[0; 101]), "too long");
        drop(file);
        let mut file = SlotFile::open(&place.0, 100).unwrap();
        assert_eq!(file.newest(), Some((7, b"record 7".to_vec())));
        assert!(file.write(8, b""));
        assert_eq!(
            SlotFile::open(&place.0, 100).unwrap().newest(),
            Some((8, Vec::new()))
        );
        file.clear();
        assert_eq!(file.newest(), None);
    }

    #[test]
    fn of_many_slots_the_newest_records_are_there_in_their_order() {
        let place = TestFile::new("many");
        let mut file = SlotFile::with_slots(&place.0, 8, 5).unwrap();
        for seq in 1..=7 {
            assert!(file.write(seq, &seq.to_le_bytes()));
        }
        drop(file);
        let file = SlotFile::with_slots(&place.0, 8, 5).unwrap();
        let seqs: Vec<_> = file.all().into_iter().map(|(seq, _)| seq).collect();
        assert_eq!(seqs, [7, 6, 5, 4, 3]);
        let file = SlotFile::with_slots(&place.0, 8, 4).unwrap();
        assert_eq!(file.all(), [], "another layout");
    }

    #[test]
    fn a_record_that_was_being_written_gives_way_to_the_one_before() {
        let place = TestFile::new("torn");
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        file.write(1, &[1; 64]);
        file.write(2, &[2; 64]);
        let slot = usize::from(file.newest_slot().unwrap().0 == 1);
        for word in 0..SLOT_HEADER + 8 {
            let victim = &file.slot(slot)[word];
            let whole = victim.load(Ordering::Relaxed);
            for bit in [0, 17, 63] {
                victim.store(whole ^ (1 << bit), Ordering::Relaxed);
                assert_eq!(
                    file.newest(),
                    Some((1, vec![1; 64])),
                    "word {word} bit {bit}"
                );
            }
            victim.store(whole, Ordering::Relaxed);
        }
        assert_eq!(file.newest(), Some((2, vec![2; 64])));
    }

    #[test]
    fn damage_is_noticed_and_a_write_that_was_cut_off_is_none() {
        let place = TestFile::new("damage");
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        file.write(1, &[1; 64]);
        file.write(2, &[2; 64]);
        let reopened = || SlotFile::open(&place.0, 64).unwrap();
        assert!(!reopened().was_damaged());
        file.slot(0)[2].store(u64::MAX, Ordering::Relaxed);
        assert!(!reopened().was_damaged());
        file.slot(1)[SLOT_HEADER].store(7, Ordering::Relaxed);
        assert!(reopened().was_damaged());
    }

    #[test]
    fn foreign_content_is_not_taken_for_ours() {
        let place = TestFile::new("foreign");
        std::fs::write(&place.0, vec![0x5a; 5000]).unwrap();
        let file = SlotFile::open(&place.0, 64).unwrap();
        assert!(file.newest().is_none() && file.was_damaged());
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        assert!(!file.was_damaged());
        file.write(1, b"ours");
        assert_eq!(
            SlotFile::open(&place.0, 128).unwrap().newest(),
            None,
            "other capacity"
        );
        assert!(SlotFile::open(&place.0, 0).is_err());
        assert!(SlotFile::open(&place.0, usize::MAX / 4).is_err());
    }
}
