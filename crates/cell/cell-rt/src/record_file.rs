//! One record of any size that survives `kill -9` at any instant.
//!
//! A record is written to a new file and renamed, so there is always a whole one:
//! the last that was written to its end. The one before stays, too, in case the newest is
//! damaged by another program. Unlike [`crate::SlotFile`] it makes system calls, and its
//! size is not fixed.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// Marks a file of this layout.
const MAGIC: [u8; 8] = *b"RCRECD01";
/// Bytes before the record: magic, length, checksum (64 bits each).
const HEAD_BYTES: usize = 24;
/// Links are not followed: a link here is not ours, and neither is its target.
const FLAGS: i32 = libc::O_NOFOLLOW | libc::O_CLOEXEC;

/// The file.
#[derive(Clone, Debug)]
pub struct RecordFile {
    path: PathBuf,
    next: PathBuf,
    older: PathBuf,
}

impl RecordFile {
    /// The file at `path`; nothing is opened yet.
    pub fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            next: path.with_extension("next"),
            older: path.with_extension("older"),
        }
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Replaces the record by `record`; at an error the one before stays.
    ///
    /// # Errors
    /// Those of the file system, for example no room.
    pub fn write(&self, record: &[u8]) -> io::Result<()> {
        let written = self.write_next(record);
        if written.is_err() {
            // A part of a record takes room that the next one may need.
            std::fs::remove_file(&self.next).ok();
        }
        written
    }

    fn write_next(&self, record: &[u8]) -> io::Result<()> {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        let mut file = options.mode(0o600).custom_flags(FLAGS).open(&self.next)?;
        let mut head = [0; HEAD_BYTES];
        head[..8].copy_from_slice(&MAGIC);
        head[8..16].copy_from_slice(&(record.len() as u64).to_le_bytes());
        head[16..].copy_from_slice(&u64::from(checksum(record)).to_le_bytes());
        file.write_all(&head)?;
        file.write_all(record)?;
        // No `fsync`: the promise is to survive a killed process, not a power cut, and the
        // directory is on tmpfs.
        drop(file);
        // In this order a kill between both renames leaves the
        // older record and the complete `.next`.
        match std::fs::rename(&self.path, &self.older) {
            // The first.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            moved => moved?,
        }
        std::fs::rename(&self.next, &self.path)
    }

    /// The newest record; `None` if none was written, or its writer was killed a moment before
    /// it was in place.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] for a file that is damaged or of another layout;
    /// those of the file system, also for a symbolic link.
    pub fn read(&self) -> io::Result<Option<Vec<u8>>> {
        read(&self.path)
    }

    /// The record before the newest.
    ///
    /// # Errors
    /// As [`RecordFile::read`].
    pub fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        read(&self.older)
    }
}

fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let mut options = OpenOptions::new();
    // A FIFO in its place must not block the start.
    options.read(true).custom_flags(FLAGS | libc::O_NONBLOCK);
    match options.open(path) {
        Ok(file) => whole(file).map(Some),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

fn whole(file: File) -> io::Result<Vec<u8>> {
    let damaged = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
    let meta = file.metadata()?;
    if !meta.is_file() {
        return Err(damaged("it is not a regular file"));
    }
    let mut head = [0; HEAD_BYTES];
    let mut reader = io::BufReader::new(file);
    let cut = |_| damaged("it is cut off");
    reader.read_exact(&mut head).map_err(cut)?;
    if head[..8] != MAGIC {
        return Err(damaged("its first bytes are of another layout"));
    }
    let number = |at: usize| {
        let bytes = head.get(at..at + 8).and_then(|bytes| bytes.try_into().ok());
        u64::from_le_bytes(bytes.unwrap_or_default())
    };
    // Compared first: a damaged length must not reserve memory.
    let length = number(8);
    if meta.len() != length.saturating_add(HEAD_BYTES as u64) {
        return Err(damaged("its length is not the one in its head"));
    }
    let mut record = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    reader.read_to_end(&mut record)?;
    if u64::from(checksum(&record)) != number(16) {
        return Err(damaged("its checksum is wrong"));
    }
    Ok(record)
}

fn checksum(record: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&(record.len() as u64).to_le_bytes());
    hasher.update(record);
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    struct TestDir(PathBuf);

    impl TestDir {
        fn new(name: &str) -> Self {
            let dir = format!("cell-rt-record-{name}-{}", std::process::id());
            let dir = std::env::temp_dir().join(dir);
            std::fs::create_dir_all(&dir).unwrap();
            Self(dir)
        }

        fn file(&self) -> RecordFile {
            RecordFile::new(&self.0.join("record"))
        }
    }

    impl Drop for TestDir {
        fn drop(&mut self) {
            std::fs::remove_dir_all(&self.0).unwrap();
        }
    }

    #[test]
    fn a_record_of_any_size_replaces_the_one_before() {
        let dir = TestDir::new("sizes");
        let file = dir.file();
        assert_eq!(file.read().unwrap(), None);
        let mut before = None;
        for length in [0, 1, 5_000_000, 7] {
            let record = vec![7; length];
            file.write(&record).unwrap();
            assert_eq!(file.read().unwrap(), Some(record));
            assert_eq!(file.read_older().unwrap(), before);
            before = file.read().unwrap();
        }
    }

    #[test]
    fn every_changed_bit_and_every_cut_is_noticed() {
        let dir = TestDir::new("damage");
        let file = dir.file();
        file.write(b"a state").unwrap();
        let whole = std::fs::read(file.path()).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            std::fs::write(file.path(), &bytes).unwrap();
            assert!(file.read().is_err(), "byte {at}");
            std::fs::write(file.path(), &whole[..at]).unwrap();
            assert!(file.read().is_err(), "cut at {at}");
        }
    }

    #[test]
    fn a_link_is_neither_read_nor_written_through() {
        let dir = TestDir::new("link");
        let (file, other) = (dir.file(), dir.0.join("other"));
        std::fs::write(&other, b"not ours").unwrap();
        for path in [&file.path, &file.next] {
            std::fs::remove_file(path).ok();
            std::os::unix::fs::symlink(&other, path).unwrap();
        }
        assert!(file.read().is_err());
        assert!(file.write(b"a state").is_err());
        // The link beside was removed with the failed write.
        file.write(b"a state").unwrap();
        assert_eq!(file.read().unwrap().as_deref(), Some(&b"a state"[..]));
        assert_eq!(std::fs::read(&other).unwrap(), b"not ours");
    }
}
