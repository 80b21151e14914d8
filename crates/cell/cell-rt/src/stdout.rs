//! Standard output of a command: the one way to write to it, and whether it was written.
//!
//! A reader that ends (`| head`) is not a failure: the output stops, and a command that
//! follows a cell looks at [`has_reader`] and ends. Output that was refused for another
//! reason, as by a full disk, is a failure even where the command did its work: a script
//! would take the truncated result for the whole one. It is remembered here until
//! [`finish`], so that no caller can forget it.

use std::fmt::Display;
use std::io::{self, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// State of the output.
#[derive(Debug)]
enum Fate {
    Open,
    /// Its reader has ended.
    Unread,
    /// It was not written, for this reason.
    Refused(io::Error),
}

static FATE: Mutex<Fate> = Mutex::new(Fate::Open);

fn fate() -> MutexGuard<'static, Fate> {
    FATE.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Fate {
    /// Nothing follows an error: a result with a gap would look like a whole one.
    fn write(&mut self, write: impl FnOnce() -> io::Result<()>) {
        if !matches!(self, Self::Open) {
            return;
        }
        if let Err(error) = write() {
            *self = match error.kind() {
                io::ErrorKind::BrokenPipe => Self::Unread,
                _ => Self::Refused(error),
            };
        }
    }

    fn take(&mut self) -> io::Result<()> {
        match std::mem::replace(self, Self::Unread) {
            Self::Refused(error) => Err(error),
            Self::Open | Self::Unread => Ok(()),
        }
    }
}

/// One line.
// One lock for the whole line, so that lines of two threads do not mix.
pub fn line(text: impl Display) {
    fate().write(|| writeln!(io::stdout().lock(), "{text}"));
}

/// Text as given. It is written at once, so that a frame in a terminal is complete.
pub fn raw(text: &[u8]) {
    fate().write(|| {
        let mut out = io::stdout().lock();
        out.write_all(text)?;
        out.flush()
    });
}

/// For code that writes to a stream. An error is remembered and returned.
#[derive(Debug, Default)]
pub struct Writer;

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        raw(bytes);
        match *fate() {
            Fate::Open => Ok(bytes.len()),
            Fate::Unread | Fate::Refused(_) => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Whether the output has a reader: false after an error, and as soon as the reader of a pipe
/// has ended, even if nothing was written since.
pub fn has_reader() -> bool {
    matches!(*fate(), Fate::Open) && is_read(io::stdout())
}

fn is_read(output: impl AsFd) -> bool {
    let mut asked = libc::pollfd {
        fd: output.as_fd().as_raw_fd(),
        events: 0,
        revents: 0,
    };
    // SAFETY: one entry, which lives for the whole call, as does its descriptor.
    let count = unsafe { libc::poll(&raw mut asked, 1, 0) };
    // An error of `poll` counts as a reader: the next write reports the truth.
    count <= 0 || asked.revents & (libc::POLLERR | libc::POLLHUP) == 0
}

/// Whether everything was written, or its reader has ended. Before the process ends, and
/// before it becomes another program.
///
/// # Errors
/// The first error of writing, once.
pub fn finish() -> io::Result<()> {
    let mut fate = fate();
    // Buffered text may fail only here, e.g. on a full disk.
    fate.write(|| io::stdout().lock().flush());
    fate.take()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::OpenOptions;

    #[test]
    fn a_full_disk_is_an_error_and_a_reader_that_ended_is_not() {
        let mut fate = Fate::Open;
        fate.write(|| Ok(()));
        let mut full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        fate.write(|| full.write_all(b"x"));
        fate.write(|| panic!("nothing is written after an error"));
        let error = fate.take().unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
        assert!(fate.take().is_ok(), "it is reported once");
        let mut fate = Fate::Open;
        let (reader, mut writer) = io::pipe().unwrap();
        drop(reader);
        fate.write(|| writer.write_all(b"x"));
        assert!(matches!(fate, Fate::Unread) && fate.take().is_ok());
    }

    #[test]
    fn a_reader_that_ended_is_noticed_before_something_is_written() {
        let (reader, writer) = io::pipe().unwrap();
        assert!(is_read(&writer));
        drop(reader);
        assert!(!is_read(&writer));
        assert!(is_read(std::fs::File::open("/dev/null").unwrap()));
    }
}
