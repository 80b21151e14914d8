//! The token that is required for commands.

use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use crate::transport::TransportError;

/// User name of clients, beside the token as password.
const USER: &str = "control";
/// Shortest token (characters).
// 24 random bytes in hexadecimal are 48; 16 is the least that cannot be tried out.
const LEAST: usize = 16;

/// Reads the token.
///
/// # Errors
/// If others can read the file as well, or it has no token.
pub(super) fn read(path: &Path) -> Result<String, TransportError> {
    let wrong = |reason: String| TransportError::Token {
        path: path.to_owned(),
        reason,
    };
    let cannot_read = |error: std::io::Error| wrong(format!("cannot be read: {error}"));
    // Checked before it is read: a token that others could read is not secret any more.
    let mode = fs::metadata(path).map_err(cannot_read)?.mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(wrong(format!(
            "has mode {mode:o}; others must not read it (mode 600)"
        )));
    }
    let text = cell_model::user_file::read_text(path).map_err(cannot_read)?;
    let token = text.trim();
    // A colon separates user and password in zenoh's file.
    let plain = |c: char| c.is_ascii_graphic() && c != ':';
    if token.len() < LEAST || !token.chars().all(plain) {
        let found = token.len();
        return Err(wrong(format!(
            "has {found} characters; {LEAST} or more of a-z, A-Z, 0-9 and signs but ':' are needed, on one line"
        )));
    }
    Ok(token.to_owned())
}

/// Users and passwords in zenoh's format; deleted when dropped.
pub(super) struct Dictionary(PathBuf);

impl std::ops::Deref for Dictionary {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Dictionary {
    fn drop(&mut self) {
        fs::remove_file(&self.0).ok();
    }
}

/// Writes the private file that zenoh needs for users and passwords.
pub(super) fn dictionary(beside: &Path, token: &str) -> Result<Dictionary, TransportError> {
    let name = format!("robocell-bridge-{}", std::process::id());
    let path = std::env::temp_dir().join(name);
    // Left by a killed process with the same number.
    fs::remove_file(&path).ok();
    let mut options = OpenOptions::new();
    // A new file, never through a link of another user.
    options.write(true).create_new(true).mode(0o600);
    let written = options
        .open(&path)
        .and_then(|mut file| writeln!(file, "{USER}:{token}"));
    written.map_err(|error| TransportError::Token {
        path: beside.to_owned(),
        reason: format!("cannot be given to zenoh in {}: {error}", path.display()),
    })?;
    Ok(Dictionary(path))
}
