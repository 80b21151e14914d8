//! Where the meshes are kept, and how a new set takes the place of the old.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::{AssetError, Manifest};

/// Folder of the cache: `ROBOCELL_CACHE_DIR`, else `robocell` in
/// `XDG_CACHE_HOME`, else in `~/.cache`. None when no variable tells.
pub fn cache_dir() -> Option<PathBuf> {
    place(|name| std::env::var_os(name))
}

fn place(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name| variable(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    // The base directory specification: a relative path there is to be ignored.
    let shared = || set("XDG_CACHE_HOME").filter(|dir| dir.is_absolute());
    set("ROBOCELL_CACHE_DIR")
        .or_else(|| Some(shared()?.join("robocell")))
        .or_else(|| Some(set("HOME")?.join(".cache").join("robocell")))
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
        let dir = cache.join(format!(".meshes-{}", std::process::id()));
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
    fn a_draft_that_cannot_replace_leaves_the_old_set() {
        let cache = tempfile::tempdir().unwrap();
        let meshes = meshes_in(cache.path());
        std::fs::create_dir_all(meshes.join("panda")).unwrap();
        // Nothing was written, so there is nothing to put in place.
        Draft::new(cache.path()).unwrap().publish().unwrap_err();
        assert!(meshes.join("panda").exists());
    }
}
