//! One launcher per run directory, by a lock the kernel drops when it dies.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Tries, 5 ms apart, while the named holder is dead.
const RETRIES: u32 = 20;

/// Held until dropped.
#[derive(Debug)]
pub struct Lock {
    _file: File,
    /// Whether another process held it before: then leftovers may exist.
    pub used_before: bool,
}

/// The process that holds a lock.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holder {
    /// Its process id.
    pub pid: u32,
    /// Since when, UTC.
    pub since: String,
}

impl Lock {
    /// Takes the lock at `path`, or returns the process that has it.
    pub fn take(path: &Path) -> io::Result<Result<Self, Holder>> {
        let mut tried = Self::try_take(path)?;
        for _ in 0..RETRIES {
            // A process that only looks holds it for a moment, too.
            match &tried {
                Err(holder)
                    if !Path::new("/proc").join(holder.pid.to_string()).exists()
                        || holder.pid == 0 =>
                {
                    std::thread::sleep(Duration::from_millis(5));
                    tried = Self::try_take(path)?;
                }
                _ => break,
            }
        }
        Ok(tried)
    }

    fn try_take(path: &Path) -> io::Result<Result<Self, Holder>> {
        let mut options = OpenOptions::new();
        options
            .read(true)
            .write(true)
            .create(true)
            // Emptied below, once the lock is ours: until then it has the pid of the holder.
            .truncate(false)
            .mode(0o600)
            .custom_flags(libc::O_NOFOLLOW);
        let mut file = options.open(path)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(Err(read_holder(&mut file))),
            Err(TryLockError::Error(error)) => return Err(error),
        }
        let used_before = file.metadata()?.len() > 0;
        file.set_len(0)?;
        file.rewind()?;
        // The file's own time stamp is when the run started.
        write!(file, "{}", std::process::id())?;
        Ok(Ok(Self {
            _file: file,
            used_before,
        }))
    }

    /// The process that holds the lock at `path` now, if one does.
    ///
    /// # Errors
    /// Where it exists and cannot be read.
    pub fn holder(path: &Path) -> io::Result<Option<Holder>> {
        let mut file = match OpenOptions::new().read(true).open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            opened => opened?,
        };
        // Shared: two commands that look at once must not take each other for the holder.
        Ok(match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => Some(read_holder(&mut file)),
            _ => None,
        })
    }
}

fn read_holder(file: &mut File) -> Holder {
    let mut text = String::new();
    let pid = match file.read_to_string(&mut text) {
        // Empty for a moment: the holder writes its pid after it has taken the lock.
        Ok(_) => text.trim().parse().unwrap_or(0),
        Err(_) => 0,
    };
    let since = file
        .metadata()
        .and_then(|meta| meta.modified())
        .map_or_else(|_| "?".to_owned(), utc);
    Holder { pid, since }
}

/// `2026-11-21 05:39:03 UTC`.
pub(crate) fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (year, month, day) = civil(seconds / 86_400);
    let of_day = seconds % 86_400;
    format!(
        "{year:04}-{month:02}-{day:02} {:02}:{:02}:{:02} UTC",
        of_day / 3600,
        of_day / 60 % 60,
        of_day % 60
    )
}

/// Year, month and day of a count of days since 1970-01-01.
fn civil(mut days: u64) -> (u64, u64, u64) {
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let mut year = 1970;
    while days >= 365 + u64::from(is_leap(year)) {
        days -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let lengths = [
        31,
        28 + u64::from(is_leap(year)),
        31,
        30,
        31,
        30,
        31,
        31,
        30,
        31,
        30,
        31,
    ];
    let mut month = 1;
    for length in lengths {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    (year, month, days + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_one_is_told_who_was_first() {
        let path = std::env::temp_dir().join(format!("robocell-lock-{}", std::process::id()));
        let first = Lock::take(&path).unwrap().unwrap();
        assert!(!first.used_before);
        let holder = Lock::take(&path).unwrap().unwrap_err();
        assert_eq!(holder.pid, std::process::id());
        assert!(holder.since.ends_with("UTC"));
        assert_eq!(
            Lock::holder(&path).unwrap().map(|h| h.pid),
            Some(holder.pid)
        );
        drop(first);
        assert_eq!(Lock::holder(&path).unwrap(), None);
        assert!(Lock::take(&path).unwrap().unwrap().used_before);
        std::fs::remove_file(path).unwrap();
    }

    #[test]
    fn dates_are_right_around_leap_days() {
        let at = |seconds| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(at(951_782_400), "2000-02-29 00:00:00 UTC");
        assert_eq!(at(1_795_239_543), "2026-11-21 05:39:03 UTC");
        assert_eq!(at(4_107_542_400), "2100-03-01 00:00:00 UTC");
    }
}
