//! A stream with an end in time.

use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::kept::Seen;

/// A stream that ends at a time, however often a few bytes arrive.
pub(super) struct Timed {
    pub(super) stream: TcpStream,
    pub(super) until: Instant,
    /// A later end, for a server that another connection has found by then.
    pub(super) extension: Option<Extension>,
}

pub(super) struct Extension {
    pub(super) until: Instant,
    pub(super) address: String,
    pub(super) seen: Arc<Seen>,
}

impl Timed {
    fn left(&mut self) -> io::Result<Duration> {
        let now = Instant::now();
        if now >= self.until
            && let Some(later) = self.extension.take()
            && later.seen.convention(&later.address).is_some()
        {
            self.until = later.until;
        }
        let left = self.until.saturating_duration_since(now);
        // A limit of zero is refused by the system.
        if left.is_zero() {
            Err(ErrorKind::TimedOut.into())
        } else {
            Ok(left)
        }
    }
}

impl Read for Timed {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let left = self.left()?;
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(bytes) {
                // Of the stream; the end of the time is that of `left`.
                Err(error) if is_late(&error) => {}
                result => return result,
            }
        }
    }
}

impl Write for Timed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let left = self.left()?;
        self.stream.set_write_timeout(Some(left))?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Whether an error is the end of a wait.
pub(super) fn is_late(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock)
}
