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

use crate::memory_dir::MemoryDir;

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
    /// In place of the file system, of a modelled process.
    memory: Option<MemoryDir>,
}

impl RecordFile {
    /// The file at `path`; nothing is opened yet.
    pub fn new(path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            next: path.with_extension("next"),
            older: path.with_extension("older"),
            memory: None,
        }
    }

    /// As [`RecordFile::new`], in a directory that is not on a disk.
    pub fn in_memory(dir: &MemoryDir, path: &Path) -> Self {
        let memory = Some(dir.clone());
        Self {
            memory,
            ..Self::new(path)
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
            self.remove(&self.next);
        }
        written
    }

    fn write_next(&self, record: &[u8]) -> io::Result<()> {
        let mut head = [0; HEAD_BYTES];
        head[..8].copy_from_slice(&MAGIC);
        head[8..16].copy_from_slice(&(record.len() as u64).to_le_bytes());
        head[16..].copy_from_slice(&u64::from(checksum(record)).to_le_bytes());
        self.create(&self.next, [&head, record])?;
        // In this order a kill between both renames leaves the older record and the complete
        // `.next`, see `read`.
        match self.rename(&self.path, &self.older) {
            // The first.
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            moved => moved?,
        }
        self.rename(&self.next, &self.path)
    }

    /// Makes the file at `path`, with these parts one after the other.
    fn create(&self, path: &Path, parts: [&[u8]; 2]) -> io::Result<()> {
        if let Some(dir) = &self.memory {
            return dir.create(path, &parts);
        }
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        let mut file = options.mode(0o600).custom_flags(FLAGS).open(path)?;
        // No `fsync`: the promise is to survive a killed process, not a power cut, and the
        // directory is on tmpfs.
        parts.iter().try_for_each(|part| file.write_all(part))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        match &self.memory {
            Some(dir) => dir.rename(from, to),
            None => std::fs::rename(from, to),
        }
    }

    fn remove(&self, path: &Path) {
        match &self.memory {
            Some(dir) => dir.remove(path),
            None => std::fs::remove_file(path).unwrap_or_default(),
        }
    }

    /// Replaces the newest record, which is damaged, by the one before.
    ///
    /// # Errors
    /// Those of the file system, for example that there is none before.
    pub fn replace_by_older(&self) -> io::Result<()> {
        self.rename(&self.older, &self.path)
    }

    /// The newest record; `None` if none was written. Completes a write whose writer was killed
    /// between its two renames: the record before may be damaged.
    ///
    /// # Errors
    /// [`io::ErrorKind::InvalidData`] for a file that is damaged or of another layout;
    /// those of the file system, also for a symbolic link.
    pub fn read(&self) -> io::Result<Option<Vec<u8>>> {
        let newest = self.read_at(&self.path)?;
        if newest.is_none()
            && let Ok(Some(complete)) = self.read_at(&self.next)
        {
            self.rename(&self.next, &self.path)?;
            return Ok(Some(complete));
        }
        Ok(newest)
    }

    /// The record before the newest.
    ///
    /// # Errors
    /// As [`RecordFile::read`].
    pub fn read_older(&self) -> io::Result<Option<Vec<u8>>> {
        self.read_at(&self.older)
    }

    fn read_at(&self, path: &Path) -> io::Result<Option<Vec<u8>>> {
        if let Some(dir) = &self.memory {
            let file = dir.read(path);
            return file
                .map(|bytes| whole(&bytes[..], bytes.len() as u64))
                .transpose();
        }
        let mut options = OpenOptions::new();
        // A FIFO in its place must not block the start.
        options.read(true).custom_flags(FLAGS | libc::O_NONBLOCK);
        match options.open(path) {
            Ok(file) => whole_file(file).map(Some),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn damaged(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.to_owned())
}

fn whole_file(file: File) -> io::Result<Vec<u8>> {
    let meta = file.metadata()?;
    if !meta.is_file() {
        return Err(damaged("it is not a regular file"));
    }
    whole(io::BufReader::new(file), meta.len())
}

/// The record of a file of `bytes` bytes.
fn whole(mut reader: impl Read, bytes: u64) -> io::Result<Vec<u8>> {
    let mut head = [0; HEAD_BYTES];
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
    if bytes != length.saturating_add(HEAD_BYTES as u64) {
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
        let dir = MemoryDir::default();
        let path = Path::new("record");
        let file = RecordFile::in_memory(&dir, path);
        // Up to records of some blocks of a checksum that is computed by blocks.
        for length in [0, 1, 7, 8, 9, 64, 1_000] {
            let record: Vec<u8> = (0..=u8::MAX).cycle().take(length).collect();
            file.write(&record).unwrap();
            let whole = dir.read(path).unwrap();
            assert_eq!(whole.len(), HEAD_BYTES + length);
            for bit in 0..8 * whole.len() {
                let mut bytes = whole.clone();
                bytes[bit / 8] ^= 1 << (bit % 8);
                dir.create(path, &[&bytes]).unwrap();
                assert!(file.read().is_err(), "bit {bit} of {length} bytes");
            }
            for cut in 0..whole.len() {
                dir.create(path, &[&whole[..cut]]).unwrap();
                assert!(file.read().is_err(), "cut at {cut} of {length} bytes");
            }
        }
    }

    #[test]
    fn a_kill_between_any_two_steps_of_a_write_leaves_a_whole_record() {
        // The new file, its head, its record, and both renames.
        for steps in 0..=5 {
            let dir = MemoryDir::default();
            let file = RecordFile::in_memory(&dir, Path::new("record"));
            file.write(b"first").unwrap();
            file.write(b"second").unwrap();
            dir.effects().allow(steps);
            file.write(b"third").unwrap();
            dir.effects().allow(u64::MAX);
            let (newest, older) = (file.read().unwrap(), file.read_older().unwrap());
            let found: Vec<_> = [newest, older].into_iter().flatten().collect();
            let wanted: &[&[u8]] = match steps {
                0..=3 => &[b"second", b"first"],
                _ => &[b"third", b"second"],
            };
            assert_eq!(found, wanted, "after {steps} steps");
            file.write(b"fourth").unwrap();
            assert_eq!(file.read().unwrap().as_deref(), Some(&b"fourth"[..]));
        }
    }

    #[test]
    fn without_room_the_record_before_stays() {
        let dir = MemoryDir::default();
        let file = RecordFile::in_memory(&dir, Path::new("record"));
        file.write(b"first").unwrap();
        dir.set_full(true);
        let error = file.write(b"second").unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert_eq!(file.read().unwrap().as_deref(), Some(&b"first"[..]));
        assert_eq!(dir.read(Path::new("record.next")), None);
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
