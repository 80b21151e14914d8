//! The plainest way to pass a value to another process: a counter that is odd while the value
//! is being written. It is the baseline with which the topic layer is compared.

use std::io;
use std::path::Path;
use std::sync::atomic::{Ordering, fence};

use crate::shared::SharedWords;

/// Words before the value, so that counter and value share no cache line.
const VALUE: usize = 16;

/// One value of a fixed number of words; one writer, any readers.
#[derive(Debug)]
pub struct Seqlock {
    memory: SharedWords,
    words: usize,
}

impl Seqlock {
    /// Opens or creates the value of `words` words in the file `path`.
    pub fn open(path: &Path, words: usize) -> io::Result<Self> {
        Ok(Self {
            memory: SharedWords::open(path, VALUE + words)?,
            words,
        })
    }

    /// Writes the value number `count` (from 1 up), word by word.
    #[inline]
    pub fn write(&self, count: u64, mut word_at: impl FnMut(usize) -> u64) {
        let words = self.memory.words();
        words[0].store(2 * count - 1, Ordering::Relaxed);
        // Odd before any word of the value, so that a reader cannot take a mixture for a value.
        fence(Ordering::Release);
        for (index, word) in words[VALUE..].iter().enumerate() {
            word.store(word_at(index), Ordering::Relaxed);
        }
        words[0].store(2 * count, Ordering::Release);
    }

    /// Copies the value number `count` out; false when another one is there, or
    /// it is being written.
    #[inline]
    pub fn read(&self, count: u64, value: &mut [u64]) -> bool {
        let words = self.memory.words();
        if words[0].load(Ordering::Acquire) != 2 * count {
            return false;
        }
        for (to, from) in value.iter_mut().zip(&words[VALUE..VALUE + self.words]) {
            *to = from.load(Ordering::Relaxed);
        }
        // The second look: an equal counter proves that no writer was active during the copy.
        fence(Ordering::Acquire);
        words[0].load(Ordering::Relaxed) == 2 * count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_sees_whole_values_only() {
        let path = std::env::temp_dir().join(format!("cell-rt-seqlock-{}", std::process::id()));
        let writer = Seqlock::open(&path, 64).unwrap();
        let reader = Seqlock::open(&path, 64).unwrap();
        let handle = std::thread::spawn(move || {
            for count in 1..=20_000 {
                writer.write(count, |index| count * 1000 + index as u64);
            }
        });
        let mut value = [0; 64];
        while !reader.read(20_000, &mut value) {
            for count in [1, 10_000, 19_999] {
                if reader.read(count, &mut value) {
                    assert!(
                        value
                            .iter()
                            .enumerate()
                            .all(|(i, v)| *v == count * 1000 + i as u64)
                    );
                }
            }
        }
        handle.join().unwrap();
        std::fs::remove_file(path).unwrap();
    }
}
