//! The task's log as a text file.

use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;

use ipc_types::trace::TraceKind;
use ipc_types::{TICK_NS, TraceLine};

/// Name of the file in the run's log folder.
pub const FILE: &str = "trace.log";

/// Appends lines to a file. A full or slow disk costs lines, but never delays a loop: only the
/// monitor waits for it.
pub struct TextLog<W> {
    out: W,
    lost: u64,
}

impl TextLog<File> {
    /// Opens the file in `logs`, or creates it.
    ///
    /// # Errors
    ///
    /// When it cannot be opened.
    pub fn open(logs: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            // Appended: a restarted monitor continues the log of the run.
            .open(logs.join(FILE))?;
        Ok(Self::new(file))
    }
}

impl<W: Write> TextLog<W> {
    /// A log that writes to `out`.
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
        // Counted, not returned: the note of the process reports the number.
        self.lost += u64::from(written.is_err());
    }

    /// Appends a request of a person at `time_s` (simulated).
    pub fn operator(&mut self, time_s: f64, text: &str) {
        let written = writeln!(self.out, "{time_s:10.3} s* {text}");
        self.lost += u64::from(written.is_err());
    }

    /// Appends that lines are missing because they were not read in time.
    pub fn gap(&mut self, lines: u64) {
        let written = writeln!(
            self.out,
            "             * {lines} lines were not read in time"
        );
        self.lost += u64::from(written.is_err());
    }

    /// Lines that the disk refused.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

/// Filters repeated requests: a drag sends the same sixty times a second, and one line is
/// enough.
#[derive(Clone, Debug, Default)]
pub struct RepeatFilter {
    last: String,
    at_ns: u64,
}

impl RepeatFilter {
    /// Repetitions within this time are one request (ns).
    // Far above the 17 ms between two requests of a moving hand.
    const PAUSE_NS: u64 = 1_000_000_000;

    /// Whether `text` starts something new at `now_ns`.
    pub fn is_new(&mut self, text: &str, now_ns: u64) -> bool {
        // Only a drag and a target are repeated.
        let can_repeat = text.starts_with("drag ") || text == "target";
        let new = !can_repeat || text != self.last || now_ns >= self.at_ns + Self::PAUSE_NS;
        text.clone_into(&mut self.last);
        self.at_ns = now_ns;
        new
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Text, Wire};

    #[test]
    fn lines_carry_the_time_of_their_tick() {
        let mut out = Vec::new();
        let mut log = TextLog::new(&mut out);
        let mut line = TraceLine::zeroed();
        line.header.tick = 12_340;
        line.text = Text::new("[decide] -> stack red_cube");
        log.line(&line);
        log.gap(3);
        let text = String::from_utf8(out).unwrap();
        assert_eq!(
            text,
            "    12.340 s  [decide] -> stack red_cube\n             * 3 lines were not read in time\n"
        );
    }

    #[test]
    fn a_drag_is_written_down_once_and_every_button_each_time() {
        let mut filter = RepeatFilter::default();
        let times = [0, 16, 32, 1100, 1116].map(|ms| ms * 1_000_000);
        let new = times.map(|now_ns| filter.is_new("drag red_cube", now_ns));
        assert_eq!(new, [true, false, false, true, false]);
        assert!(filter.is_new("pause", 0) && filter.is_new("pause", 0));
        let mut out = Vec::new();
        TextLog::new(&mut out).operator(1.5, "operator: pause");
        assert_eq!(out, b"     1.500 s* operator: pause\n");
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
        let mut log = TextLog::new(Full);
        log.line(&TraceLine::zeroed());
        assert_eq!(log.lost(), 1);
    }
}
