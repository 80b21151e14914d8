//! Replacing a file in one step: a reader, and the next start after a power failure, find the
//! old or the new file, never a part of one.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _, chown};
use std::path::{Path, PathBuf};

/// Names of drafts beside one file that are tried: a process replaces a few files at a time.
const TRIES: u32 = 1000;
/// In the names of all drafts.
const INFIX: &str = ".robocell-";

/// The replacement of a file, under a name that no file had. It is removed when it is dropped
/// before [`Draft::publish`].
#[derive(Debug)]
pub struct Draft {
    /// The file to replace: of a link its target.
    target: PathBuf,
    path: PathBuf,
    is_published: bool,
}

impl Draft {
    /// Chooses a name beside the file at `path`, which need not exist, with the same ending.
    /// Nothing is created. Drafts of this file that killed processes have left are removed.
    ///
    /// # Errors
    /// Returns an error if `path` is a link to a file that does
    /// not exist, and if no name is free.
    pub fn beside(path: &Path) -> io::Result<Self> {
        // A rename would replace the link itself and leave the file as it is.
        let target = if path.is_symlink() {
            fs::canonicalize(path)?
        } else {
            path.to_owned()
        };
        let name = Name::of(&target);
        name.remove_abandoned();
        let free = (0..TRIES).map(|number| name.draft(number));
        let free = free
            .into_iter()
            // Not `exists`: a link to a missing file takes the name as well.
            .find(|draft| fs::symlink_metadata(draft).is_err());
        let path = free.ok_or_else(|| {
            let text = format!(
                "no name of a temporary file beside {} is free",
                target.display()
            );
            io::Error::new(io::ErrorKind::AlreadyExists, text)
        })?;
        Ok(Self {
            target,
            path,
            is_published: false,
        })
    }

    /// Its name until it is published. It has to be created by `create_new`, so that a file that
    /// appears there meanwhile is kept.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Creates it with mode `mode`, which the file it replaces overrides.
    ///
    /// # Errors
    /// Returns an error if it cannot be created.
    pub fn create(&self, mode: u32) -> io::Result<File> {
        let mut options = OpenOptions::new();
        let options = options.write(true).create_new(true).mode(mode);
        options.open(&self.path)
    }

    /// Puts it in place of the file, with the mode and owner of that. When this returns, a power
    /// failure does not undo it.
    ///
    /// # Errors
    /// Returns an error if it was not created, or the file cannot be replaced.
    pub fn publish(self) -> io::Result<()> {
        File::open(&self.path)?.sync_all()?;
        let dir = parent(&self.target).to_owned();
        self.publish_unsynced()?;
        File::open(dir)?.sync_all()
    }

    /// As [`Draft::publish`], for a file that has to survive a kill of the process, but not a
    /// power failure.
    ///
    /// # Errors
    /// As [`Draft::publish`].
    pub fn publish_unsynced(mut self) -> io::Result<()> {
        if let Ok(replaced) = fs::metadata(&self.target) {
            let made = fs::metadata(&self.path)?;
            if (made.uid(), made.gid()) != (replaced.uid(), replaced.gid()) {
                // Refused to all but the superuser. The content counts more than its owner.
                chown(&self.path, Some(replaced.uid()), Some(replaced.gid())).ok();
            }
            // After `chown`, which clears the bits for setuid and setgid.
            let mode = Permissions::from_mode(replaced.mode() & 0o7777);
            fs::set_permissions(&self.path, mode)?;
        }
        // Atomic within one directory.
        fs::rename(&self.path, &self.target)?;
        self.is_published = true;
        Ok(())
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if !self.is_published {
            // It may not have been created.
            fs::remove_file(&self.path).ok();
        }
    }
}

/// Replaces the file at `path` by one with `bytes`; a new file has mode `mode`.
///
/// # Errors
/// As [`Draft::beside`] and [`Draft::publish`].
pub fn replace(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    write(path, bytes, mode)?.publish()
}

/// As [`replace`], for the files of a run directory, which is in memory.
///
/// # Errors
/// As [`replace`].
pub fn replace_unsynced(path: &Path, bytes: &[u8], mode: u32) -> io::Result<()> {
    write(path, bytes, mode)?.publish_unsynced()
}

fn write(path: &Path, bytes: &[u8], mode: u32) -> io::Result<Draft> {
    let draft = Draft::beside(path)?;
    draft.create(mode)?.write_all(bytes)?;
    Ok(draft)
}

/// Folder, name without ending, and ending of a file.
struct Name<'a> {
    dir: &'a Path,
    stem: String,
    ending: String,
}

impl<'a> Name<'a> {
    fn of(path: &'a Path) -> Self {
        let text = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        Self {
            dir: parent(path),
            stem: text(path.file_stem()),
            ending: text(path.extension()),
        }
    }

    /// `.STEM.robocell-PID-NUMBER.ENDING`.
    fn draft(&self, number: u32) -> PathBuf {
        let (stem, ending, pid) = (&self.stem, &self.ending, std::process::id());
        self.dir
            .join(format!(".{stem}{INFIX}{pid}-{number}.{ending}"))
    }

    /// Removes the drafts of this file whose process has ended.
    fn remove_abandoned(&self) {
        for entry in fs::read_dir(self.dir).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let pid = name.to_str().and_then(|name| self.pid_of(name));
            if pid.is_some_and(|pid| !Path::new("/proc").join(pid.to_string()).exists()) {
                // Left over, it only takes space.
                fs::remove_file(entry.path()).ok();
            }
        }
    }

    /// The process of the draft of this file with this name.
    fn pid_of(&self, name: &str) -> Option<u32> {
        let name = name.strip_prefix('.')?.strip_prefix(self.stem.as_str())?;
        let name = name
            .strip_prefix(INFIX)?
            .strip_suffix(self.ending.as_str())?;
        let (pid, number) = name.strip_suffix('.')?.split_once('-')?;
        number.parse::<u32>().ok()?;
        pid.parse().ok()
    }
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(dir) if !dir.as_os_str().is_empty() => dir,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    fn names(dir: &Path) -> Vec<String> {
        let entries = fs::read_dir(dir).unwrap().flatten();
        let mut names: Vec<_> = entries
            .map(|entry| entry.file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn files_of_the_user_beside_it_are_kept_and_nothing_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("my.tree.json");
        let beside = [
            "my.tree.draft",
            "my.tree.json.sorted",
            "my.tree.partial.json",
            "my.tree.json~",
        ];
        for name in beside {
            fs::write(dir.path().join(name), "mine").unwrap();
        }
        for text in ["first", "second"] {
            replace(&path, text.as_bytes(), 0o644).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        for name in beside {
            assert_eq!(fs::read_to_string(dir.path().join(name)).unwrap(), "mine");
        }
        assert_eq!(names(dir.path()).len(), beside.len() + 1);
        let given_up = Draft::beside(&path).unwrap();
        given_up.create(0o600).unwrap();
        drop(given_up);
        assert_eq!(names(dir.path()).len(), beside.len() + 1);
    }

    #[test]
    fn of_a_link_the_target_is_replaced_and_the_mode_is_kept() {
        let dir = tempfile::tempdir().unwrap();
        let there = dir.path().join("repository");
        fs::create_dir(&there).unwrap();
        let (file, link) = (there.join("job.json"), dir.path().join("job.json"));
        fs::write(&file, "old").unwrap();
        symlink("repository/job.json", &link).unwrap();
        for mode in [0o640, 0o600, 0o664, 0o755] {
            fs::set_permissions(&file, Permissions::from_mode(mode)).unwrap();
            replace(&link, b"new", 0o644).unwrap();
            assert!(link.is_symlink());
            assert_eq!(fs::read_to_string(&file).unwrap(), "new");
            assert_eq!(fs::metadata(&file).unwrap().mode() & 0o7777, mode);
        }
        assert_eq!(names(&there), ["job.json"]);
        fs::remove_file(&file).unwrap();
        assert!(replace(&link, b"new", 0o644).is_err());
        assert!(link.is_symlink() && !file.exists());
    }

    #[test]
    fn the_owner_is_kept_where_that_is_allowed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("theirs");
        fs::write(&path, "old").unwrap();
        // Only the superuser may give a file away.
        if chown(&path, Some(65_534), Some(65_534)).is_err() {
            return;
        }
        replace(&path, b"new", 0o644).unwrap();
        let meta = fs::metadata(&path).unwrap();
        assert_eq!((meta.uid(), meta.gid()), (65_534, 65_534));
    }

    #[test]
    fn two_drafts_have_two_names_and_those_of_killed_processes_are_removed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.mcap");
        // No process has a number above the limit of the kernel, 2^22.
        let dead = dir.path().join(".run.robocell-4194305-0.mcap");
        let parent = std::os::unix::process::parent_id();
        let alive = dir.path().join(format!(".run.robocell-{parent}-0.mcap"));
        let other = dir.path().join(".run.robocell-mine.mcap");
        for file in [&dead, &alive, &other] {
            fs::write(file, "").unwrap();
        }
        let first = Draft::beside(&path).unwrap();
        drop(first.create(0o600).unwrap());
        let second = Draft::beside(&path).unwrap();
        assert_ne!(first.path(), second.path());
        assert_eq!(first.path().extension(), path.extension());
        assert!(!dead.exists() && alive.exists() && other.exists());
        first.publish().unwrap();
        assert!(path.exists());
        assert!(second.publish().is_err(), "it was not created");
    }
}
