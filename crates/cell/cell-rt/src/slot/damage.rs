//! Damage of a file in memory, for a model of a process that starts on one.

use std::sync::atomic::Ordering;

use super::layout::{FILE_HEADER, MAGIC, SLOT_HEADER, slot_words};
use super::{MemoryFile, SlotFile};

/// A bit that was changed.
#[derive(Clone, Debug)]
pub struct Flipped {
    word: usize,
    value: u64,
}

impl MemoryFile {
    /// Flips a bit that belongs to the head of the file or to a whole record, chosen by `draw`;
    /// `None` for a file without records.
    pub fn flip(&self, draw: u64) -> Option<Flipped> {
        let words = self.words();
        let header: &[_; FILE_HEADER] = words.first_chunk()?;
        let [magic, capacity, slots] = header.each_ref().map(|w| w.load(Ordering::Acquire));
        if magic != MAGIC {
            return None;
        }
        let (capacity, slots) = (usize::try_from(capacity), usize::try_from(slots));
        let (capacity, slots) = (capacity.ok()?, slots.ok()?);
        let file = SlotFile::in_memory(self, capacity, slots).ok()?;
        // Words that count, and how many of their bits do: those behind the end of a record are
        // no part of it.
        let mut counts = vec![(0, 64), (2, 64)];
        for (slot, _, record) in file.all_slots() {
            let start = FILE_HEADER + slot * slot_words(capacity);
            counts.extend((start..start + SLOT_HEADER).map(|word| (word, 64)));
            let parts = record.chunks(8).zip(start + SLOT_HEADER..);
            counts.extend(parts.map(|(part, word)| (word, 8 * part.len())));
        }
        if counts.len() == 2 {
            return None;
        }
        let place = usize::try_from(draw % counts.len() as u64).ok()?;
        let (word, bits) = *counts.get(place)?;
        let bit = (draw >> 32) % bits as u64;
        let value = words.get(word)?.fetch_xor(1 << bit, Ordering::AcqRel) ^ (1 << bit);
        Some(Flipped { word, value })
    }

    /// Whether nothing was written in the place of `flipped` since.
    pub fn still_has(&self, flipped: &Flipped) -> bool {
        let words = self.words();
        let word = words.get(flipped.word);
        word.is_some_and(|word| word.load(Ordering::Acquire) == flipped.value)
    }
}
