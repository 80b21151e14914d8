//! The task's log as a text file.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use ipc_types::trace::TraceKind;
use ipc_types::{TICK_NS, TraceLine};

/// Name of the file in the run's log folder.
pub const FILE: &str = "trace.log";

/// Appends lines to a file. A disk that is full or slow costs lines, never a
/// loop: only the monitor waits for it.
pub struct Journal<W> {
    out: W,
    lost: u64,
}

impl Journal<File> {
    /// Opens the file in `logs`, or begins it.
    ///
    /// # Errors
    ///
    /// When it cannot be opened.
    pub fn open(logs: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(logs.join(FILE))?;
        Ok(Self::new(file))
    }
}

impl<W: Write> Journal<W> {
    /// A journal that writes to `out`.
    pub fn new(out: W) -> Self {
        Self { out, lost: 0 }
    }

    /// Writes one line, if it is for people.
    pub fn line(&mut self, line: &TraceLine) {
        let kind = TraceKind::from_code(line.kind);
        if !kind.is_some_and(TraceKind::is_for_people) {
            return;
        }
        let time_s = (line.header.tick * TICK_NS) as f64 / 1.0e9;
        let mark = match kind {
            Some(TraceKind::Lifecycle) => "* ",
            _ => "  ",
        };
        let written = writeln!(self.out, "{time_s:10.3} s{mark}{}", line.text);
        self.lost += u64::from(written.is_err());
    }

    /// Says that lines are missing because nobody read them in time.
    pub fn gap(&mut self, lines: u64) {
        let written = writeln!(
            self.out,
            "             * {lines} lines were not read in time"
        );
        self.lost += u64::from(written.is_err());
    }

    /// Lines the disk did not take.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Text, Wire};

    #[test]
    fn lines_carry_the_time_of_their_tick() {
        let mut out = Vec::new();
        let mut journal = Journal::new(&mut out);
        let mut line = TraceLine::zeroed();
        line.header.tick = 12_340;
        line.text = Text::new("[decide] -> stack red_cube");
        journal.line(&line);
        journal.gap(3);
        let text = String::from_utf8(out).unwrap();
        assert_eq!(
            text,
            "    12.340 s  [decide] -> stack red_cube\n             * 3 lines were not read in time\n"
        );
    }

    #[test]
    fn a_full_disk_is_counted_and_survived() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut journal = Journal::new(Full);
        journal.line(&TraceLine::zeroed());
        assert_eq!(journal.lost(), 1);
    }
}
