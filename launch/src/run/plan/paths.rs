//! Paths of the command line.

use std::fs;
use std::path::{Path, PathBuf};

use supervisor::failure::{Context, Failure};

/// A file system with less room than this takes no recording (bytes).
const LEAST_FREE_BYTES: u64 = 1 << 20;

pub(super) fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    fs::canonicalize(path).map_err(|error| {
        Failure::configuration(format!(
            "{}: {error}; give the path of an existing file or directory",
            path.display()
        ))
    })
}

/// The path of a file that may not exist yet, in a directory that does.
pub(crate) fn new_file(path: &Path) -> Result<PathBuf, Failure> {
    let name = path
        .file_name()
        .ok_or_else(|| Failure::usage(format!("{}: that names no file", path.display())))?;
    let parent = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let path = absolute(parent)?.join(name);
    check_new(&path)?;
    Ok(path)
}

/// Whether a file can be made at `path`, and hold something.
fn check_new(path: &Path) -> Result<(), Failure> {
    let show = path.display();
    let refuse = |why: String| {
        Err(Failure::configuration(format!(
            "cannot record to {show}: {why}; give the path of a new file"
        )))
    };
    // Not `metadata`, which takes a link without a target for a file that does not exist.
    match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_dir() => return refuse("it is a directory".to_owned()),
        Ok(meta) if meta.is_file() => return refuse("it exists already".to_owned()),
        Ok(_) => return refuse("it is a device, a pipe, a socket or a link".to_owned()),
        Err(_) => {}
    }
    // The recorder makes the file later, in another process: without this test its error would come
    // after the start of the run.
    let made = fs::File::options().write(true).create_new(true).open(path);
    if let Err(error) = made.and_then(|_| fs::remove_file(path)) {
        return refuse(error.to_string());
    }
    let dir = path.parent().unwrap_or(Path::new("/"));
    let free = cell_rt::memory::free_bytes(dir).cannot(format!("look at {}", dir.display()))?;
    if free < LEAST_FREE_BYTES {
        return refuse(format!(
            "its file system has {free} bytes free, a second of a recording takes about 1 MB"
        ));
    }
    Ok(())
}
