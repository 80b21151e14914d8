//! Reads a log from its first kept line, and then the lines that are added.

use std::fs::File;
use std::io;
use std::path::Path;

use super::read_from;

/// A log, and how far it was read.
#[derive(Debug)]
pub struct Follower {
    file: File,
    position: u64,
}

impl Follower {
    /// Of the log at `path`.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self {
            file: File::open(path)?,
            position: 0,
        })
    }

    /// Appends the new lines to `out`.
    pub fn read(&mut self, out: &mut Vec<u8>) -> io::Result<()> {
        if self.file.metadata()?.len() < self.position {
            // A file system without holes: the log began again.
            out.extend_from_slice(MISSING);
            self.position = 0;
        }
        let mut new = Vec::new();
        let missing = read_from(&mut self.file, self.position, &mut new)?;
        let mut lines = new.as_slice();
        if missing > 0 {
            if self.position > 0 {
                out.extend_from_slice(MISSING);
            }
            // The rest of a line whose beginning is not kept.
            let end = lines.iter().position(|byte| *byte == b'\n');
            lines = &lines[end.map_or(0, |end| end + 1)..];
        }
        out.extend_from_slice(lines);
        self.position += missing + new.len() as u64;
        Ok(())
    }
}

const MISSING: &[u8] = b"\n(lines are missing here: more was written than a log keeps)\n";
