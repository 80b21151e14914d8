//! The directory with the run directories of all cells, and the check that no other user can
//! change its content.

use std::fs::{self, DirBuilder, Metadata};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use cell_rt::memory::is_tmpfs;
use cell_rt::process::user_id;

use super::ENV_RUN_DIR;
use crate::failure::{Context, Failure};

/// Permission bits of group and others.
const OTHERS: u32 = 0o077;
/// Bits of these by which entries can be exchanged.
const OTHERS_WRITE: u32 = 0o022;

/// The directory that the user names.
fn named() -> Option<PathBuf> {
    let dir = std::env::var_os(ENV_RUN_DIR).filter(|dir| !dir.is_empty())?;
    let dir = PathBuf::from(dir);
    let dir = std::path::absolute(&dir).unwrap_or(dir);
    // Without a slash at the end: by `link/` the system looks at the target of a link.
    Some(dir.components().collect())
}

fn default_base() -> PathBuf {
    // Only in memory: a journal commit of a disk would hold the launcher and physics at once.
    if let Some(dir) = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from)
        && dir.is_absolute()
        && is_tmpfs(&dir).unwrap_or(false)
    {
        return dir.join("robocell");
    }
    PathBuf::from(format!("/dev/shm/robocell-{}", user_id()))
}

/// The directory with the run directories of all cells. It need not exist.
///
/// # Errors
/// Where it is no directory, a link, or another user can change it.
pub fn checked_base() -> Result<PathBuf, Failure> {
    let base = named().unwrap_or_else(default_base);
    check_base(&base)?;
    Ok(base)
}

/// A directory of this user for locks of resources that all cells of the machine share, such as
/// ports; it exists.
///
/// # Errors
/// Where no directory can be made that no other user can change.
// A port is one of the machine, so cells with run directories at other places need the same
// locks. Where the common place cannot be used, that of this cell is better than none.
pub fn shared_locks() -> Result<PathBuf, Failure> {
    let made = |dir: PathBuf| make_base(&dir).map(|()| dir);
    made(default_base()).or_else(|failure| named().map_or(Err(failure), made))
}

/// Makes the directory `base` where it is missing.
pub(super) fn make_base(base: &Path) -> Result<(), Failure> {
    let show = base.display();
    make_private(base, true).cannot(format!("make the directory of run directories {show}"))?;
    check_base(base)
}

/// [`check`] of the directory above run directories. One that the user names may be readable
/// for others, as one made by `mkdir` is: the run directories in it are not.
fn check_base(base: &Path) -> Result<(), Failure> {
    let forbidden = if *base == default_base() {
        OTHERS
    } else {
        OTHERS_WRITE
    };
    check(base, forbidden, "remove it")
}

/// [`check`] of a run directory.
pub(super) fn check_run_dir(path: &Path) -> Result<(), Failure> {
    check(path, OTHERS, "remove it, choose another name with `--cell`")
}

/// Refuses `path` if it is no directory, is a link, belongs to another user, or has
/// one of the `forbidden` bits: another user could exchange the files in it, among them the
/// programs that the next process is told to start. A missing one is fine.
fn check(path: &Path, forbidden: u32, remedy: &str) -> Result<(), Failure> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(error).cannot(format!("look at the run directory {}", path.display())),
        Ok(meta) => defect(&meta, forbidden).map_or(Ok(()), |defect| {
            Err(Failure::configuration(format!(
                "the run directory {} {defect}; another user could exchange the files of a cell, so nothing \
                 in it is used: {remedy}, or set {ENV_RUN_DIR} to a directory of your own (mode 700)",
                path.display()
            )))
        }),
    }
}

fn defect(meta: &Metadata, forbidden: u32) -> Option<String> {
    if meta.is_symlink() {
        return Some("is a symbolic link and no directory".to_owned());
    }
    if !meta.is_dir() {
        return Some("is a file and no directory".to_owned());
    }
    let is_private = meta.uid() == user_id() && meta.mode() & forbidden == 0;
    (!is_private).then(|| {
        format!(
            "belongs to user {} with mode {:o}, not to you (user {}) alone",
            meta.uid(),
            meta.mode() & 0o777,
            user_id()
        )
    })
}

/// Makes a directory only its user can read; whether it was not there before.
pub(super) fn make_private(path: &Path, recursive: bool) -> io::Result<bool> {
    match DirBuilder::new()
        .recursive(recursive)
        .mode(0o700)
        .create(path)
    {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use std::fs::Permissions;
    use std::os::unix::fs::{PermissionsExt as _, chown, symlink};

    use super::*;

    fn said(path: &Path, forbidden: u32) -> String {
        check(path, forbidden, "remove it").unwrap_err().message
    }

    #[test]
    fn a_directory_that_others_can_change_is_refused_with_its_owner_and_mode() {
        let dir = tempfile::tempdir().unwrap();
        let base = dir.path().join("base");
        check(&base, OTHERS, "").unwrap();
        assert!(make_private(&base, false).unwrap());
        check(&base, OTHERS, "").unwrap();
        for mode in [0o777, 0o770, 0o702, 0o720] {
            fs::set_permissions(&base, Permissions::from_mode(mode)).unwrap();
            for forbidden in [OTHERS, OTHERS_WRITE] {
                let said = said(&base, forbidden);
                assert!(said.contains(&format!("mode {mode:o}")), "{said}");
                assert!(said.contains(ENV_RUN_DIR), "{said}");
            }
        }
        fs::set_permissions(&base, Permissions::from_mode(0o755)).unwrap();
        assert!(said(&base, OTHERS).contains("755"));
        check(&base, OTHERS_WRITE, "").unwrap();
        let link = dir.path().join("link");
        symlink(&base, &link).unwrap();
        assert!(said(&link, OTHERS_WRITE).contains("symbolic link"));
        fs::write(dir.path().join("file"), "").unwrap();
        assert!(said(&dir.path().join("file"), OTHERS).contains("no directory"));
        fs::set_permissions(&base, Permissions::from_mode(0o700)).unwrap();
        // Only the superuser can give a directory away.
        if chown(&base, Some(65_534), None).is_ok() {
            assert!(said(&base, OTHERS_WRITE).contains("user 65534"));
        }
    }
}
