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
//! A change must not break: the order of the stores in `stores` (`layout.rs`); the header is stored
//! backwards, its magic last; a writer never touches the newest whole record.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::shared::SharedWords;

mod damage;
mod layout;
mod place;
#[cfg(test)]
mod tests;

pub use damage::Flipped;
use layout::{
    CHECKSUM, FILE_HEADER, Found, MAGIC, MAX_CAPACITY, MAX_SLOTS, SLOT_HEADER, checksum,
    slot_words, stores, words,
};
pub use place::MemoryFile;
use place::Place;

/// The file of slots. Writing allocates nothing and makes no system call, unless the
/// record is longer than all before it.
#[derive(Debug)]
pub struct SlotFile {
    place: Place,
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
        Self::at(Place::File(path.to_owned()), capacity, slots)
    }

    /// As [`Self::with_slots`], in memory: for a model of a process that is killed.
    pub fn in_memory(file: &MemoryFile, capacity: usize, slots: usize) -> io::Result<Self> {
        Self::at(Place::Memory(file.clone()), capacity, slots)
    }

    fn at(place: Place, capacity: usize, slots: usize) -> io::Result<Self> {
        let fits = (1..=MAX_CAPACITY).contains(&capacity) && (2..=MAX_SLOTS).contains(&slots);
        if !fits {
            let text = format!(
                "{slots} slots of {capacity} bytes; 2 to {MAX_SLOTS} of 1 to {MAX_CAPACITY} bytes \
                 are possible"
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        let found = place.find(slots)?;
        let capacity = match found {
            // Longer slots of a former start are kept, as
            // shortening them would lose its records.
            Found::Ours(found) => found.max(capacity),
            Found::Nothing | Found::Damaged => capacity,
        };
        // Slots of another length start at other offsets.
        let is_kept = matches!(found, Found::Ours(found) if found == capacity);
        let mut this = Self {
            memory: place.map(words(capacity, slots))?,
            place,
            capacity,
            slots,
            next: 0,
            // No start asks for slots this short, so the length is damaged.
            damaged: match found {
                Found::Damaged => true,
                Found::Ours(found) => found < capacity,
                Found::Nothing => false,
            },
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
        let stored = self.slot(slot)[CHECKSUM].load(Ordering::Acquire);
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
        self.store(slot, stores(seq, record));
        Ok(())
    }

    fn store(&self, slot: usize, stores: impl Iterator<Item = (usize, u64)>) {
        let slot = self.slot(slot % self.slots);
        // Each store after all before it: a reader that sees new content sees the mark, one
        // that sees the checksum all content.
        let store = |(word, value): (usize, u64)| slot[word].store(value, Ordering::Release);
        match self.place.effects() {
            None => stores.for_each(store),
            Some(effects) => stores.take_while(|_| effects.happens()).for_each(store),
        }
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
        let beside = self.place.beside();
        let grown = Self::at(beside.clone(), capacity, self.slots).and_then(|mut grown| {
            for (slot, seq, record) in self.all_slots() {
                grown.write_at(slot, seq, &record)?;
            }
            self.place.replace_by(&beside)?;
            Ok(grown)
        });
        // Without room the short slots stay valid; a leftover would take the room they need.
        let grown = grown.inspect_err(|_| beside.remove())?;
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
            self.slot(slot)[CHECKSUM].store(u64::MAX, Ordering::Release);
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
        let stored = slot[CHECKSUM].load(Ordering::Acquire);
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
