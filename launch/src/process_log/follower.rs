//! Reads a log from its older part on, and what is added to it.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::older;

/// What tells an older part from the one before it: numbers of files are used again.
type Identity = (u64, i64, i64);

/// A log, and how far it was read.
#[derive(Debug)]
pub(crate) struct Follower {
    path: PathBuf,
    file: File,
    /// Bytes of the newest part that were read.
    position: u64,
    /// The older part whose lines were read.
    older: Option<Identity>,
    /// There is a new older part, and the log was not seen truncated.
    waits: bool,
}

impl Follower {
    /// Of the log at `path`; both parts are new.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            file: File::open(path)?,
            path: path.to_owned(),
            position: 0,
            older: None,
            // An older part that is there now was complete before the log was opened.
            waits: true,
        })
    }

    /// Appends what is new to `out`.
    pub(crate) fn read(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        // The length before the older part: what is seen truncated has its new older part.
        let is_truncated = self.file.metadata()?.len() < self.position;
        let path = older(&self.path);
        let there = path.metadata().ok();
        let identity = there.map(|meta| (meta.ino(), meta.mtime(), meta.mtime_nsec()));
        if identity.is_some() && identity != self.older {
            // It is there some microseconds before the truncation. A log that was as long
            // again by now looks the same the next time.
            if !is_truncated && !std::mem::replace(&mut self.waits, true) {
                return Ok(());
            }
            self.read_older(&path, out)?;
            (self.older, self.position) = (identity, 0);
        } else if is_truncated {
            self.position = 0;
        }
        self.waits = false;
        self.file.seek(SeekFrom::Start(self.position))?;
        self.position += self.file.read_to_end(out)? as u64;
        Ok(())
    }

    /// The end of the part before, from where it was read to.
    fn read_older(&mut self, path: &Path, out: &mut Vec<u8>) -> io::Result<()> {
        let mut file = File::open(path)?;
        if file.metadata()?.len() < self.position {
            out.extend_from_slice(
                b"(lines are missing here: the log was rotated more than once)\n",
            );
            self.position = 0;
        }
        file.seek(SeekFrom::Start(self.position))?;
        file.read_to_end(out)?;
        Ok(())
    }
}
