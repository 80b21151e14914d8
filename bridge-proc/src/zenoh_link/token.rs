//! The token that commands are accepted with.

use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use crate::transport::TransportError;

/// Name that clients authenticate with, beside the token.
const USER: &str = "control";
/// Shortest token (characters).
const LEAST: usize = 16;

/// Reads the token.
///
/// # Errors
/// Where others can read the file too, or it has no token.
pub(super) fn read(path: &Path) -> Result<String, TransportError> {
    let wrong = |reason: String| TransportError::Token {
        path: path.to_owned(),
        reason,
    };
    let cannot_read = |error: std::io::Error| wrong(format!("cannot be read: {error}"));
    let mode = fs::metadata(path).map_err(cannot_read)?.mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(wrong(format!(
            "has mode {mode:o}; others must not read it (mode 600)"
        )));
    }
    let text = cell_model::user_file::read_text(path).map_err(cannot_read)?;
    let token = text.trim();
    let plain = |c: char| c.is_ascii_graphic() && c != ':';
    if token.len() < LEAST || !token.chars().all(plain) {
        let found = token.len();
        return Err(wrong(format!(
            "has {found} characters; {LEAST} or more of a-z, A-Z, 0-9 and signs but ':' are needed, on one line"
        )));
    }
    Ok(token.to_owned())
}

/// Users and passwords in the form that zenoh reads; gone when it is dropped.
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

/// A private file for zenoh, which wants users and passwords in a file.
pub(super) fn dictionary(beside: &Path, token: &str) -> Result<Dictionary, TransportError> {
    let name = format!("robocell-bridge-{}", std::process::id());
    let path = std::env::temp_dir().join(name);
    // Of a process with the same number that was killed.
    fs::remove_file(&path).ok();
    let mut options = OpenOptions::new();
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
