//! Where the slots are: in a file, or in the memory of a model.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::layout::{FILE_HEADER, Found};
use crate::effects::Effects;
use crate::shared::SharedWords;

/// A file in the memory of this process. Its clones are the same file: one of them for a
/// modelled process, and one for its successor.
#[derive(Clone, Debug, Default)]
pub struct MemoryFile {
    words: Arc<Mutex<Arc<[AtomicU64]>>>,
    effects: Effects,
}

impl MemoryFile {
    /// An empty file of processes with these effects.
    pub fn new(effects: &Effects) -> Self {
        let (words, effects) = (Arc::default(), effects.clone());
        Self { words, effects }
    }

    pub(super) fn words(&self) -> Arc<[AtomicU64]> {
        // No store is half done by a panic, so a poisoned file is as good.
        self.words
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn replace(&self, words: Arc<[AtomicU64]>) {
        *self.words.lock().unwrap_or_else(PoisonError::into_inner) = words;
    }
}

/// The place of a slot file.
#[derive(Clone, Debug)]
pub(super) enum Place {
    File(PathBuf),
    Memory(MemoryFile),
}

impl Place {
    /// Looks for a slot file of `slots` slots at this place.
    pub(super) fn find(&self, slots: usize) -> io::Result<Found> {
        let file = match self {
            Self::File(path) => return Found::at(path, slots),
            Self::Memory(file) => file.words(),
        };
        let header = file.first_chunk::<FILE_HEADER>();
        let header = header.map(|header| header.each_ref().map(|w| w.load(Ordering::Acquire)));
        let bytes = file.len() as u64 * 8;
        Ok(header.map_or(Found::Nothing, |header| Found::of(header, bytes, slots)))
    }

    /// Its memory, with room for `words` words.
    pub(super) fn map(&self, words: usize) -> io::Result<SharedWords> {
        let file = match self {
            Self::File(path) => return SharedWords::open(path, words),
            Self::Memory(file) => file,
        };
        let mut old = file.words();
        if old.len() < words {
            let kept = old.iter().map(|word| word.load(Ordering::Relaxed));
            let longer = kept.chain(std::iter::repeat(0)).take(words);
            old = longer.map(AtomicU64::new).collect();
            file.replace(old.clone());
        }
        Ok(SharedWords::of(old))
    }

    /// What counts the stores of its process; `None` for a file.
    pub(super) fn effects(&self) -> Option<&Effects> {
        match self {
            Self::File(_) => None,
            Self::Memory(file) => Some(&file.effects),
        }
    }

    /// An empty place that can replace this one.
    pub(super) fn beside(&self) -> Self {
        match self {
            Self::File(path) => {
                let path = grown(path);
                // Left by a process that was killed while it used it.
                std::fs::remove_file(&path).ok();
                Self::File(path)
            }
            Self::Memory(file) => Self::Memory(MemoryFile::new(&file.effects)),
        }
    }

    /// Gives the content of `other` to this place, as a whole.
    pub(super) fn replace_by(&self, other: &Self) -> io::Result<()> {
        match (self, other) {
            (Self::File(path), Self::File(other)) => std::fs::rename(other, path)?,
            (Self::Memory(file), Self::Memory(other)) => {
                if file.effects.happens() {
                    file.replace(other.words());
                }
            }
            (Self::File(_), Self::Memory(_)) | (Self::Memory(_), Self::File(_)) => {}
        }
        Ok(())
    }

    /// Removes what [`Self::beside`] made.
    pub(super) fn remove(&self) {
        if let Self::File(path) = self {
            std::fs::remove_file(path).ok();
        }
    }
}

/// The file that replaces the one at `path`.
pub(super) fn grown(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".grown");
    name.into()
}
