//! A directory of files that are written by steps, in memory: for a model of a process that is
//! killed between two of them.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::effects::Effects;

/// Files by path. Its clones are the same directory.
#[derive(Clone, Debug, Default)]
pub struct MemoryDir {
    inner: Arc<Mutex<Inner>>,
    effects: Effects,
}

#[derive(Debug, Default)]
struct Inner {
    files: BTreeMap<PathBuf, Vec<u8>>,
    is_full: bool,
}

impl MemoryDir {
    /// Counts the steps of its writer: a file is made, a part is appended to it, a file is renamed
    /// or removed.
    pub fn effects(&self) -> &Effects {
        &self.effects
    }

    /// Whether there is no room from now on.
    pub fn set_full(&self, is_full: bool) {
        self.inner().is_full = is_full;
    }

    /// The content of the file at `path`.
    pub fn read(&self, path: &Path) -> Option<Vec<u8>> {
        self.inner().files.get(path).cloned()
    }

    /// Flips the bit of the file at `path` that `draw` chooses; its new content, or `None` where
    /// there is no such file.
    pub fn flip(&self, path: &Path, draw: u64) -> Option<Vec<u8>> {
        let mut inner = self.inner();
        let file = inner.files.get_mut(path)?;
        let bit = draw % (8 * file.len().max(1) as u64);
        let byte = file.get_mut(usize::try_from(bit / 8).ok()?)?;
        *byte ^= 1 << (bit % 8);
        Some(file.clone())
    }

    /// Makes the file at `path`, with these parts one after the other.
    pub(crate) fn create(&self, path: &Path, parts: &[&[u8]]) -> io::Result<()> {
        if !self.effects.happens() {
            return Ok(());
        }
        let mut inner = self.inner();
        let is_full = inner.is_full;
        let file = inner.files.entry(path.to_owned()).or_default();
        file.clear();
        for part in parts {
            if is_full {
                return Err(io::ErrorKind::StorageFull.into());
            }
            if self.effects.happens() {
                file.extend_from_slice(part);
            }
        }
        Ok(())
    }

    pub(crate) fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        if self.effects.happens() {
            let mut inner = self.inner();
            let file = inner.files.remove(from).ok_or(io::ErrorKind::NotFound)?;
            inner.files.insert(to.to_owned(), file);
        }
        Ok(())
    }

    pub(crate) fn remove(&self, path: &Path) {
        if self.effects.happens() {
            self.inner().files.remove(path);
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // No step is half done by a panic, so a poisoned directory is as good.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
