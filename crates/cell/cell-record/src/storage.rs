//! The file system of the flight recorder; tests replace it by a disk that fills up.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Operations that the flight recorder needs of a file system.
pub trait Storage: Send {
    /// Creates a file, and the directory it is in.
    ///
    /// # Errors
    ///
    /// Of the file system.
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Write + Send>>;

    /// Removes a file.
    ///
    /// # Errors
    ///
    /// Of the file system.
    fn remove(&mut self, path: &Path) -> io::Result<()>;

    /// Files of a directory and their sizes (bytes); none for a missing directory.
    fn list(&mut self, dir: &Path) -> Vec<(PathBuf, u64)>;
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Storage for Disk {
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Write + Send>> {
        // Created each time: a directory that was removed under the recorder is not its end.
        if let Some(dir) = path.parent() {
            std::fs::create_dir_all(dir)?;
        }
        // `create_new`: a recording is never written over another one.
        let file = std::fs::File::options()
            .write(true)
            .create_new(true)
            .open(path)?;
        Ok(Box::new(file))
    }

    fn remove(&mut self, path: &Path) -> io::Result<()> {
        std::fs::remove_file(path)
    }

    fn list(&mut self, dir: &Path) -> Vec<(PathBuf, u64)> {
        let Ok(entries) = std::fs::read_dir(dir) else {
            return Vec::new();
        };
        let sized = entries.filter_map(|entry| {
            let entry = entry.ok()?;
            let meta = entry.metadata().ok()?;
            // Regular files only: a link in the ring is not ours to remove or to count.
            meta.is_file().then(|| (entry.path(), meta.len()))
        });
        sized.collect()
    }
}
