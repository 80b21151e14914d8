//! A run of a cell, for the processes that take part in it.

pub mod children;
pub mod incident;
pub mod message;
pub mod output;
pub mod phase_name;
mod phases;
pub(crate) mod policy_name;
pub mod policy_server;
pub mod python;
pub mod record;
pub mod report;
pub mod script_report;
pub mod secrets;
pub mod spec;
pub mod speed;
pub mod summary;
mod summary_text;
pub mod wire;
pub mod worker_args;

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Writes `bytes` to `path` with mode `mode`. A reader at any time sees the old or the new
/// file, never a part of it.
///
/// # Errors
/// Returns an error if the folder or the file cannot be written.
pub fn replace_file(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    let draft = path.with_extension("draft");
    // A draft left by a killed process may have another mode, and `create_new` would fail.
    match fs::remove_file(&draft) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    let mut file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(mode)
        .open(&draft)?;
    file.write_all(bytes)?;
    // A rename within one directory is atomic; the file is not synced, since it has to survive
    // a kill of the process and not of the machine.
    fs::rename(draft, path)
}
