//! Records that survive `kill -9` at any instant.
//!
//! A mapped file has two slots or more, written in turn, each with a checksum over its content.
//! While one is being written the others are whole. A record that is longer than a slot moves
//! the whole records to a file with longer slots, which replaces the old one.
//!
//! What can go wrong: the writer is killed between any two stores; the file is cut off, of
//! another build, or a link; a length is damaged. The rule: a slot is marked invalid before its
//! content changes and gets its checksum last, and nothing is used whose checksum is wrong.
//!
//! A change must not break: the order of the stores in `write_at`; the header is stored
//! backwards, its magic last; a writer never touches the newest whole record.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering, fence};

use crate::shared::SharedWords;

mod layout;

use layout::{
    FILE_HEADER, Found, MAGIC, MAX_CAPACITY, MAX_SLOTS, SLOT_HEADER, checksum, slot_words, word_of,
    words,
};

/// The file of slots. Writing allocates nothing and makes no system call, unless the
/// record is longer than all before it.
#[derive(Debug)]
pub struct SlotFile {
    path: PathBuf,
    memory: SharedWords,
    capacity: usize,
    slots: usize,
    next: usize,
    damaged: bool,
}

impl SlotFile {
    /// Opens or creates the file at `path` (on tmpfs) for records of `capacity` bytes, more if
    /// needed. A file of another layout is initialised: its content belongs to another build.
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
        let found = Found::at(path, slots)?;
        let capacity = match found {
            // Longer slots of a former start are kept, as
            // shortening them would lose its records.
            Found::Ours(found) => found.max(capacity),
            Found::Nothing | Found::Damaged => capacity,
        };
        // Slots of another length start at other offsets.
        let is_kept = matches!(found, Found::Ours(found) if found == capacity);
        let mut this = Self {
            path: path.to_owned(),
            memory: SharedWords::open(path, words(capacity, slots))?,
            capacity,
            slots,
            next: 0,
            damaged: matches!(found, Found::Damaged),
        };
        // Found while the old content is still there: the caller reports lost records.
        if is_kept {
            this.damaged = (0..slots).any(|slot| this.is_damaged_slot(slot));
        } else {
            this.initialise();
        }
        // The oldest slot is the one to write next.
        this.next = match this.newest_slot() {
            Some((slot, _)) => (slot + 1) % slots,
            None => 0,
        };
        Ok(this)
    }

    fn initialise(&mut self) {
        self.clear();
        let header = [MAGIC, self.capacity as u64, self.slots as u64];
        // Backwards: the magic is stored last, so a file killed
        // here reads as empty, not as damaged.
        for (word, value) in self.memory.words().iter().zip(header).rev() {
            word.store(value, Ordering::Release);
        }
    }

    /// Whether the file was damaged, cut off, or of another layout when it was opened: records
    /// of it are lost. A record whose writer was killed while writing it does not count.
    pub fn was_damaged(&self) -> bool {
        self.damaged
    }

    /// Neither empty, nor being written, nor whole.
    fn is_damaged_slot(&self, slot: usize) -> bool {
        let stored = self.slot(slot)[2].load(Ordering::Acquire);
        stored != 0 && stored != u64::MAX && self.read(slot).is_none()
    }

    /// Number of slots.
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// Writes a record over the oldest. `seq` identifies the newest record and must grow.
    ///
    /// # Errors
    /// Where the record is longer than any before it and there is no room for longer
    /// slots, or it is longer than 64 MiB. The records before it stay.
    pub fn write(&mut self, seq: u64, record: &[u8]) -> io::Result<()> {
        let slot = self.next;
        // `next` moves only after success: a failed write must
        // not cost a good record its place.
        self.write_at(slot, seq, record)?;
        self.next = (slot + 1) % self.slots;
        Ok(())
    }

    /// As [`Self::write`], over the record in `slot`, counted as the records of
    /// [`Self::all`] are.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_at(&mut self, slot: usize, seq: u64, record: &[u8]) -> io::Result<()> {
        if record.len() > self.capacity {
            self.grow(record.len())?;
        }
        let slot = self.slot(slot % self.slots);
        // Not valid while it is being written: no record has a checksum above
        // 32 bits.
        slot[2].store(u64::MAX, Ordering::Relaxed);
        // The mark must be visible before any new content, or an
        // old checksum could cover a mixture.
        fence(Ordering::SeqCst);
        slot[0].store(seq, Ordering::Relaxed);
        slot[1].store(record.len() as u64, Ordering::Relaxed);
        for (word, bytes) in slot[SLOT_HEADER..].iter().zip(record.chunks(8)) {
            word.store(word_of(bytes), Ordering::Relaxed);
        }
        // And all content before its checksum.
        fence(Ordering::SeqCst);
        slot[2].store(u64::from(checksum(seq, record)), Ordering::Release);
        Ok(())
    }

    /// Moves the whole records to slots for `needed` bytes in a file of their own, which
    /// replaces this one: a process killed meanwhile leaves one of the two.
    fn grow(&mut self, needed: usize) -> io::Result<()> {
        let capacity = needed.next_power_of_two().min(MAX_CAPACITY);
        if needed > capacity {
            let text = format!("a record of {needed} bytes; at most {MAX_CAPACITY} are kept");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        // A new file and a rename, not a longer old one: slots
        // of another length overlap the old.
        let path = grown(&self.path);
        // Left by a process that was killed here.
        std::fs::remove_file(&path).ok();
        let grown = Self::with_slots(&path, capacity, self.slots).and_then(|mut grown| {
            for (slot, seq, record) in self.all_slots() {
                grown.write_at(slot, seq, &record)?;
            }
            std::fs::rename(&path, &self.path)?;
            Ok(grown)
        });
        // Without room the short slots stay valid; a leftover would take the room they need.
        let grown = grown.inspect_err(|_| {
            std::fs::remove_file(&path).ok();
        })?;
        (self.memory, self.capacity) = (grown.memory, grown.capacity);
        Ok(())
    }

    /// The newest whole record with its `seq`.
    pub fn newest(&self) -> Option<(u64, Vec<u8>)> {
        let (slot, seq) = self.newest_slot()?;
        // The slot may have been overwritten between the two
        // reads; then its number has changed.
        self.read(slot).filter(|(read_seq, _)| *read_seq == seq)
    }

    /// All whole records with their `seq`, the newest first.
    pub fn all(&self) -> Vec<(u64, Vec<u8>)> {
        let mut all: Vec<_> = self
            .all_slots()
            .map(|(_, seq, record)| (seq, record))
            .collect();
        all.sort_by_key(|(seq, _)| core::cmp::Reverse(*seq));
        all
    }

    /// All whole records with their slot and their `seq`.
    pub fn all_slots(&self) -> impl Iterator<Item = (usize, u64, Vec<u8>)> {
        (0..self.slots).filter_map(|slot| {
            let (seq, record) = self.read(slot)?;
            Some((slot, seq, record))
        })
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
        let length = slot_words(self.capacity);
        &self.memory.words()[FILE_HEADER + index * length..][..length]
    }

    fn read(&self, index: usize) -> Option<(u64, Vec<u8>)> {
        let slot = self.slot(index);
        let stored = slot[2].load(Ordering::Acquire);
        let seq = slot[0].load(Ordering::Relaxed);
        let length = usize::try_from(slot[1].load(Ordering::Relaxed)).ok()?;
        // Before memory is reserved: a damaged length may be anything.
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

/// The file that replaces the one at `path`.
fn grown(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".grown");
    name.into()
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
            file.write(seq, format!("record {seq}").as_bytes()).unwrap();
        }
        drop(file);
        let mut file = SlotFile::open(&place.0, 100).unwrap();
        assert_eq!(file.newest(), Some((7, b"record 7".to_vec())));
        file.write(8, b"").unwrap();
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
            file.write(seq, &seq.to_le_bytes()).unwrap();
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
        file.write(1, &[1; 64]).unwrap();
        file.write(2, &[2; 64]).unwrap();
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
        file.write(1, &[1; 64]).unwrap();
        file.write(2, &[2; 64]).unwrap();
        let reopened = || SlotFile::open(&place.0, 64).unwrap();
        assert!(!reopened().was_damaged());
        file.slot(0)[2].store(u64::MAX, Ordering::Relaxed);
        assert!(!reopened().was_damaged());
        file.slot(1)[SLOT_HEADER].store(7, Ordering::Relaxed);
        assert!(reopened().was_damaged());
    }

    #[test]
    fn a_record_longer_than_all_before_makes_the_slots_longer() {
        let place = TestFile::new("grown");
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        file.write(1, &[1; 64]).unwrap();
        file.write(2, &[2; 64]).unwrap();
        // Left by a process that was killed while it did this.
        std::fs::write(grown(&place.0), b"a part").unwrap();
        file.write(3, &vec![3; 200_000]).unwrap();
        let found = [(3, vec![3; 200_000]), (2, vec![2; 64])];
        assert_eq!(file.all(), found);
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        assert!(!file.was_damaged());
        assert_eq!(file.all(), found, "read by a process that expects less");
        assert!(file.write(4, &vec![0; MAX_CAPACITY + 1]).is_err());
        assert_eq!(file.all(), found);
    }

    #[test]
    fn a_file_that_was_cut_off_is_damaged() {
        let place = TestFile::new("cut");
        let mut file = SlotFile::open(&place.0, 5_000).unwrap();
        file.write(1, &[1; 5_000]).unwrap();
        drop(file);
        let whole = std::fs::read(&place.0).unwrap();
        for length in [1, 23, 24, 3_000, whole.len() - 1] {
            std::fs::write(&place.0, &whole[..length]).unwrap();
            let file = SlotFile::open(&place.0, 5_000).unwrap();
            assert!(file.was_damaged() && file.newest().is_none(), "{length}");
        }
    }

    #[test]
    fn foreign_content_is_not_taken_for_ours() {
        let place = TestFile::new("foreign");
        std::fs::write(&place.0, vec![0x5a; 5000]).unwrap();
        let file = SlotFile::open(&place.0, 64).unwrap();
        assert!(file.newest().is_none() && file.was_damaged());
        let mut file = SlotFile::open(&place.0, 64).unwrap();
        assert!(!file.was_damaged());
        file.write(1, b"ours").unwrap();
        assert!(SlotFile::open(&place.0, 0).is_err());
        assert!(SlotFile::open(&place.0, usize::MAX / 4).is_err());
    }
}
