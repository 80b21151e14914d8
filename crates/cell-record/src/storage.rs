//! Where files are kept; tests put a disk that fills in its place.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// What the flight recorder needs of a file system.
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

    /// Files of a directory and their bytes; none where there is no directory.
    fn list(&mut self, dir: &Path) -> Vec<(PathBuf, u64)>;
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Storage for Disk {
    fn create(&mut self, path: &Path) -> io::Result<Box<dyn Write + Send>> {
        if let Some(dir) = path.parent() {
            std::fs::create_dir_all(dir)?;
        }
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
            meta.is_file().then(|| (entry.path(), meta.len()))
        });
        sized.collect()
    }
}
