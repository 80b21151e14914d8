//! Reading files that a user names, with a bound on their size and without waiting for ever.
//!
//! A pipe with a writer is read, as made by `<(command)` in a shell. A device, and a named pipe
//! without a writer, are refused before anything is read.

use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, BufRead, Read};
use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
use std::path::Path;

use crate::encoding;

/// Files larger than this are not robots or cells (bytes): a wrong file is not read into
/// memory.
pub const MAX_FILE_BYTES: u64 = 4 << 20;
/// Largest size of a line in a file of rows (bytes).
pub const MAX_LINE_BYTES: u64 = 1 << 20;

/// A file or pipe that is read once, from its start.
#[derive(Debug)]
pub struct UserFile {
    /// The first bytes of a pipe, which were read to test for a writer.
    head: io::Cursor<Vec<u8>>,
    file: File,
}

impl UserFile {
    /// Opens the file or pipe at `path`.
    ///
    /// # Errors
    /// Returns an error if it cannot be opened, is neither file nor pipe, or is a pipe without
    /// a writer.
    pub fn open(path: &Path) -> io::Result<Self> {
        let kind = fs::metadata(path)?.file_type();
        if !kind.is_fifo() {
            return Ok(Self {
                head: io::Cursor::default(),
                file: open_file(path)?,
            });
        }
        let mut options = OpenOptions::new();
        // Without this flag the open would wait until there is a writer.
        let mut probe = options
            .read(true)
            .custom_flags(libc::O_NONBLOCK)
            .open(path)?;
        let mut head = vec![0; 4096];
        match probe.read(&mut head) {
            Ok(0) => return Err(refused("it is a pipe that no program writes to")),
            Ok(count) => head.truncate(count),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => head.clear(),
            Err(error) => return Err(error),
        }
        Ok(Self {
            head: io::Cursor::new(head),
            // Reads from here on wait for the writer. It exists, so this open does not wait.
            file: File::open(path)?,
        })
    }
}

impl Read for UserFile {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        match self.head.read(out)? {
            0 => self.file.read(out),
            count => Ok(count),
        }
    }
}

/// Opens a file that is read at several places, or more than once; a pipe is refused, too.
///
/// # Errors
/// Returns an error if it cannot be opened, or is not a regular file.
pub fn open_file(path: &Path) -> io::Result<File> {
    regular(fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    // Checked a second time: another file may have replaced it since.
    regular(file.metadata()?.file_type())?;
    Ok(file)
}

/// The bytes of the file or pipe at `path`, at most `limit`.
///
/// # Errors
/// As [`UserFile::open`], and if it has more bytes.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let count = UserFile::open(path)?
        // One byte more than the limit, by which a longer file is detected without reading it.
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if count as u64 > limit {
        return Err(refused(&format!("it has more than {limit} bytes")));
    }
    Ok(bytes)
}

/// The text of the file or pipe at `path`, at most [`MAX_FILE_BYTES`].
///
/// # Errors
/// As [`read`], and if it is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let bytes = read(path, MAX_FILE_BYTES)?;
    encoding::text(bytes).map_err(|reason| refused(&reason))
}

/// Replaces `line` by the next line of a file of rows, with its line end; returns the number of
/// bytes, 0 at the end of the file.
///
/// # Errors
/// Returns an error if it cannot be read, is not UTF-8, or has more than [`MAX_LINE_BYTES`].
pub fn read_line(rows: &mut impl BufRead, line: &mut String) -> io::Result<usize> {
    line.clear();
    // The memory of the line before is used again, not allocated for each row.
    let mut bytes = std::mem::take(line).into_bytes();
    let count = rows
        .take(MAX_LINE_BYTES + 1)
        .read_until(b'\n', &mut bytes)?;
    if count as u64 > MAX_LINE_BYTES {
        return Err(refused(&format!(
            "it has a line of more than {MAX_LINE_BYTES} bytes"
        )));
    }
    *line = encoding::text(bytes).map_err(|reason| refused(&reason))?;
    Ok(count)
}

/// Whether a file can be written at `path`: there is a regular file, or none. Nothing is
/// created.
///
/// # Errors
/// Returns an error for anything else, such as a device or a directory, and if the directory
/// does not exist.
pub fn check_output(path: &Path) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(meta) => regular(meta.file_type()),
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Err(_) if path.is_symlink() => Err(refused("it is a link to a file that does not exist")),
        Err(_) => match path.parent() {
            Some(dir) if !dir.as_os_str().is_empty() && !dir.is_dir() => Err(refused(&format!(
                "the directory {} does not exist",
                dir.display()
            ))),
            Some(_) => Ok(()),
            None => Err(refused("it is a directory")),
        },
    }
}

fn regular(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    Err(refused(&format!(
        "it is {}; name a regular file",
        if kind.is_dir() {
            "a directory"
        } else if kind.is_fifo() {
            "a pipe"
        } else if kind.is_socket() {
            "a socket"
        } else {
            "a device"
        }
    )))
}

fn refused(reason: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufReader, Write as _};

    fn reason<T: std::fmt::Debug>(result: io::Result<T>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn a_pipe_with_a_writer_is_read_whole() {
        let (reader, mut writer) = io::pipe().unwrap();
        let path = format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&reader));
        let path = Path::new(&path);
        assert_eq!(reason(open_file(path)), "it is a pipe; name a regular file");
        writer.write_all(b"one\n").unwrap();
        let mut file = UserFile::open(path).unwrap();
        writer.write_all(b"two\n").unwrap();
        drop(writer);
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "one\ntwo\n");
        assert_eq!(
            reason(read_text(path)),
            "it is a pipe that no program writes to"
        );
    }

    #[test]
    fn what_does_not_end_is_refused_before_it_is_read() {
        for device in ["/dev/zero", "/dev/null", "/dev/full"] {
            let device = Path::new(device);
            assert_eq!(
                reason(read_text(device)),
                "it is a device; name a regular file"
            );
            assert!(check_output(device).is_err());
        }
        assert!(reason(read_text(Path::new("/"))).contains("a directory"));
        assert!(check_output(Path::new("/")).is_err());
    }

    #[test]
    fn size_and_length_of_a_line_are_bounded() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert_eq!(reason(read(&path, 4)), "it has more than 4 bytes");
        let long = "x".repeat(1 << 20);
        let mut rows = BufReader::new(io::Cursor::new(format!("a\n{long}\n")));
        let mut line = "before".to_owned();
        assert_eq!(read_line(&mut rows, &mut line).unwrap(), 2);
        assert_eq!(line, "a\n");
        let too_long = "it has a line of more than 1048576 bytes";
        assert_eq!(reason(read_line(&mut rows, &mut line)), too_long);
    }

    #[test]
    fn an_output_is_a_file_in_a_directory_that_exists() {
        let dir = tempfile::tempdir().unwrap();
        let new = dir.path().join("new");
        check_output(&new).unwrap();
        check_output(Path::new("new")).unwrap();
        assert!(!new.exists());
        std::os::unix::fs::symlink(&new, dir.path().join("link")).unwrap();
        let link = dir.path().join("link");
        assert_eq!(
            reason(check_output(&link)),
            "it is a link to a file that does not exist"
        );
        fs::write(&new, "").unwrap();
        check_output(&link).unwrap();
        let reason = reason(check_output(&dir.path().join("no/new")));
        assert!(reason.contains("does not exist"), "{reason}");
    }
}
