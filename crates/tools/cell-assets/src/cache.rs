//! Where the meshes are kept, and how a new set takes the place of the old.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use cell_rt::process::is_alive;

use crate::{AssetError, Manifest};

/// Folder of the cache: `ROBOCELL_CACHE_DIR`, else `robocell` in
/// `XDG_CACHE_HOME`, else in `~/.cache`. None when no variable tells.
pub fn cache_dir() -> Option<PathBuf> {
    place(|name| std::env::var_os(name))
}

fn place(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    cell_rt::user_dir(variable, "ROBOCELL_CACHE_DIR", "XDG_CACHE_HOME", ".cache")
}

/// The folder with `ROBOT/LINK.glb`, when a whole set of meshes is there.
pub fn meshes_dir() -> Option<PathBuf> {
    let meshes = meshes_in(&cache_dir()?);
    let manifest = Manifest::load(&meshes).ok()?;
    manifest.is_current(&meshes).then_some(meshes)
}

/// The folder of the meshes in a cache.
pub fn meshes_in(cache: &Path) -> PathBuf {
    cache.join("meshes")
}

/// Start of the name of a draft; the number of its process follows.
const DRAFT: &str = ".meshes-";

/// Removes the drafts of processes that were killed: each may have the size of all meshes.
fn remove_abandoned(cache: &Path) {
    for entry in std::fs::read_dir(cache).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let pid = name.to_str().and_then(|name| name.strip_prefix(DRAFT));
        let pid = pid.and_then(|pid| pid.parse().ok());
        if pid.is_some_and(|pid| !is_alive(pid)) {
            let (meshes, old) = (meshes_in(cache), entry.path().join("old"));
            // Killed while it put its set in place of this one.
            if !meshes.exists() {
                // Fails where nothing was moved away yet: then no set is lost.
                std::fs::rename(old, meshes).unwrap_or_default();
            }
            // Left over, it only takes space.
            std::fs::remove_dir_all(entry.path()).unwrap_or_default();
        }
    }
}

/// A folder in the making. It is removed again unless it is published.
#[derive(Debug)]
pub struct Draft {
    dir: PathBuf,
    meshes: PathBuf,
}

impl Draft {
    /// Starts one in `cache`, beside the place it is for.
    ///
    /// # Errors
    ///
    /// When the folder cannot be made.
    pub fn new(cache: &Path) -> Result<Self, AssetError> {
        remove_abandoned(cache);
        // In the cache itself: a rename works only within one file system.
        let dir = cache.join(format!("{DRAFT}{}", std::process::id()));
        if dir.exists() {
            // A process of that number died here.
            std::fs::remove_dir_all(&dir).map_err(AssetError::file("removing", &dir))?;
        }
        std::fs::create_dir_all(&dir).map_err(AssetError::file("making", &dir))?;
        let meshes = meshes_in(cache);
        Ok(Self { dir, meshes })
    }

    /// Scratch space that is not published.
    ///
    /// # Errors
    ///
    /// When the folder cannot be made.
    pub fn scratch(&self) -> Result<PathBuf, AssetError> {
        let dir = self.dir.join("scratch");
        std::fs::create_dir_all(&dir).map_err(AssetError::file("making", &dir))?;
        Ok(dir)
    }

    /// Writes one file, with the folders it needs.
    ///
    /// # Errors
    ///
    /// When that fails.
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), AssetError> {
        let path = self.dir.join("new").join(path);
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(AssetError::file("making", folder))?;
        }
        std::fs::write(&path, bytes).map_err(AssetError::file("writing", &path))
    }

    /// Puts it in place in one step; what was there goes.
    ///
    /// # Errors
    ///
    /// When a folder cannot be renamed; what was there is put back.
    pub fn publish(self) -> Result<PathBuf, AssetError> {
        let old = self.dir.join("old");
        // A folder cannot be renamed onto one that has files, so the old set is moved away first. A
        // process that is killed between the two renames leaves it in `old`, where the next start
        // finds it (see `remove_abandoned`).
        let replaces = self.meshes.exists();
        if replaces {
            std::fs::rename(&self.meshes, &old)
                .map_err(AssetError::file("moving away", &self.meshes))?;
        }
        let renamed = std::fs::rename(self.dir.join("new"), &self.meshes);
        if let Err(error) = renamed {
            if replaces {
                std::fs::rename(&old, &self.meshes)
                    .map_err(AssetError::file("putting back", &self.meshes))?;
            }
            return Err(AssetError::file("putting in place", &self.meshes)(error));
        }
        Ok(self.meshes.clone())
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // Left over, it only takes space.
        std::fs::remove_dir_all(&self.dir).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_variable_tells_the_place() {
        let all = |name: &str| Some(OsString::from(format!("/{name}")));
        assert_eq!(place(all), Some("/ROBOCELL_CACHE_DIR".into()));
        let no_own = |name: &str| all(name).filter(|_| name != "ROBOCELL_CACHE_DIR");
        assert_eq!(place(no_own), Some("/XDG_CACHE_HOME/robocell".into()));
        let home = |name: &str| all(name).filter(|_| name == "HOME");
        assert_eq!(place(home), Some("/HOME/.cache/robocell".into()));
        assert_eq!(place(|_| None), None);
    }

    #[test]
    fn a_draft_is_seen_whole_or_not_at_all() {
        let cache = tempfile::tempdir().unwrap();
        let meshes = meshes_in(cache.path());
        let file = Path::new("panda/panda_link0.glb");

        let given_up = Draft::new(cache.path()).unwrap();
        given_up.write(file, b"half").unwrap();
        assert!(!meshes.exists());
        drop(given_up);
        assert_eq!(std::fs::read_dir(cache.path()).unwrap().count(), 0);

        for text in ["first", "second"] {
            let draft = Draft::new(cache.path()).unwrap();
            draft.write(file, text.as_bytes()).unwrap();
            assert_eq!(draft.publish().unwrap(), meshes);
            assert_eq!(std::fs::read_to_string(meshes.join(file)).unwrap(), text);
        }
        assert_eq!(std::fs::read_dir(cache.path()).unwrap().count(), 1);
    }

    #[test]
    fn drafts_of_processes_that_ended_are_removed() {
        let cache = tempfile::tempdir().unwrap();
        // No process has a number above the limit of the kernel, 2^22.
        let killed = cache.path().join(".meshes-4194305");
        let parent = std::os::unix::process::parent_id();
        let running = cache.path().join(format!(".meshes-{parent}"));
        let other = cache.path().join(".meshes-of-mine");
        for dir in [&killed, &running, &other] {
            std::fs::create_dir_all(dir.join("new/panda")).unwrap();
        }
        // It was killed while it replaced a set.
        std::fs::create_dir(killed.join("old")).unwrap();
        drop(Draft::new(cache.path()).unwrap());
        assert!(meshes_in(cache.path()).exists());
        assert!(!killed.exists());
        assert!(running.exists() && other.exists());
    }

    #[test]
    fn a_draft_that_cannot_replace_leaves_the_old_set() {
        let cache = tempfile::tempdir().unwrap();
        let meshes = meshes_in(cache.path());
        std::fs::create_dir_all(meshes.join("panda")).unwrap();
        // Nothing was written, so there is nothing to put in place.
        Draft::new(cache.path()).unwrap().publish().unwrap_err();
        assert!(meshes.join("panda").exists());
    }
}
