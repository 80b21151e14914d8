//! Sources of robots and cells: built into the program, or a directory.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::error::ModelError;
use crate::{suggest, toml_text, user_file};

/// Path within the data, and text, of files that are built into a program.
type BuiltIn = &'static [(&'static str, &'static str)];

/// A source of robots and cells.
#[derive(Clone, Debug)]
pub struct Data {
    origin: Origin,
    /// Source of the robots that `origin` does not have.
    robots: Option<Box<Data>>,
    /// Log of the files that were read, if there is one.
    log: Option<ReadLog>,
}

/// Every file that was read, by its path within the data, with its text.
#[derive(Clone, Debug, Default)]
pub struct ReadLog(Arc<Mutex<BTreeMap<String, String>>>);

impl ReadLog {
    /// The files that were read until now.
    pub fn files(&self) -> BTreeMap<String, String> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, String>> {
        // A poisoned lock is used: an insertion into the map is complete or has not happened.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[derive(Clone, Debug)]
enum Origin {
    BuiltIn(BuiltIn),
    Dir(PathBuf),
}

impl Data {
    /// Files that are built into a program: path within the data, and text.
    pub fn files(files: BuiltIn) -> Self {
        Self::of(Origin::BuiltIn(files))
    }

    /// A directory with `robots/` and `cells/` (option `--data DIR`).
    pub fn dir(dir: impl Into<PathBuf>) -> Self {
        Self::of(Origin::Dir(dir.into()))
    }

    fn of(origin: Origin) -> Self {
        Self {
            origin,
            robots: None,
            log: None,
        }
    }

    /// The same source with a log of every file that is read from now on, by this value and its
    /// clones.
    #[must_use]
    pub fn logged(mut self) -> (Self, ReadLog) {
        let log = self.log.take().unwrap_or_default();
        self.log = Some(log.clone());
        (self, log)
    }

    /// These cells, with the robots of `other` where a name is missing here.
    #[must_use]
    pub fn with_robots_of(self, other: &Self) -> Self {
        Self {
            robots: Some(Box::new(other.clone())),
            ..self
        }
    }

    /// Whether there is a folder for the robot that the file `path` belongs to; `true` for
    /// every other file.
    fn has_robot_of(&self, path: &str) -> bool {
        let Some((robot, _)) = path.strip_prefix("robots/").and_then(|p| p.split_once('/')) else {
            return true;
        };
        let folder = format!("robots/{robot}/");
        match &self.origin {
            Origin::Dir(dir) => dir.join(folder).is_dir(),
            Origin::BuiltIn(files) => files.iter().any(|(name, _)| name.starts_with(&folder)),
        }
    }

    /// The checkout from which this library was built: for tests, benches and examples, and for
    /// programs built in a checkout for use there.
    pub fn checkout() -> Self {
        Self::dir(Self::checkout_dir())
    }

    /// Directory of [`Data::checkout`].
    pub fn checkout_dir() -> PathBuf {
        let own = Path::new(env!("CARGO_MANIFEST_DIR"));
        own.ancestors().nth(3).unwrap_or(own).to_owned()
    }

    /// Text of a file by its path within the data, for example `cells/franka-stack.toml`.
    ///
    /// # Errors
    /// Returns [`ModelError::Read`] if it is missing, unreadable or larger than
    /// [`MAX_FILE_BYTES`](user_file::MAX_FILE_BYTES).
    pub fn read(&self, path: &str) -> Result<Cow<'static, str>, ModelError> {
        let text = self.find(path)?;
        if let Some(log) = &self.log {
            log.lock()
                .insert(path.to_owned(), text.clone().into_owned());
        }
        Ok(text)
    }

    fn find(&self, path: &str) -> Result<Cow<'static, str>, ModelError> {
        // By folder, not by file: the files of two robots with one name must not be mixed.
        if let Some(robots) = self.robots.as_ref().filter(|_| !self.has_robot_of(path)) {
            return robots.find(path);
        }
        let files = match &self.origin {
            Origin::Dir(dir) => return read_text(&dir.join(path)).map(Cow::Owned),
            Origin::BuiltIn(files) => files,
        };
        match files.iter().find(|(name, _)| *name == path) {
            Some((_, text)) => Ok(Cow::Borrowed(text)),
            None => Err(ModelError::Read {
                file: path.to_owned(),
                reason: "not built into this program".to_owned(),
                advice: suggest::advice(
                    path,
                    &files.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
                ),
            }),
        }
    }

    /// Name of a file for messages: in a directory, the path that opens it.
    pub fn name_of(&self, path: &str) -> String {
        if let Some(robots) = self.robots.as_ref().filter(|_| !self.has_robot_of(path)) {
            return robots.name_of(path);
        }
        match &self.origin {
            Origin::Dir(dir) => dir.join(path).display().to_string(),
            Origin::BuiltIn(_) => path.to_owned(),
        }
    }

    /// Name and one-line description of every demo, sorted by name. For a cell file that cannot
    /// be read the description is the reason.
    pub fn demos(&self) -> Vec<(String, String)> {
        let mut demos: Vec<_> = self
            .cell_names()
            .into_iter()
            .map(|name| {
                let text = self.read(&format!("cells/{name}.toml"));
                let description = match text {
                    Ok(text) => {
                        toml_text::top_level_string(&text, "description").unwrap_or_default()
                    }
                    Err(error) => error.to_string(),
                };
                (name, description)
            })
            .collect();
        demos.sort();
        demos
    }

    /// Names of the robots, each with a folder below `robots/`; sorted.
    pub fn robot_names(&self) -> Vec<String> {
        let mut names = match &self.origin {
            Origin::Dir(dir) => {
                let entries = std::fs::read_dir(dir.join("robots"));
                let entries = entries.into_iter().flatten().flatten();
                let folders = entries.filter(|entry| entry.path().is_dir());
                folders
                    .map(|entry| entry.file_name().to_string_lossy().into_owned())
                    .collect()
            }
            Origin::BuiltIn(files) => {
                let paths = files.iter().map(|(path, _)| *path);
                let robots = paths.filter_map(|path| path.strip_prefix("robots/")?.split_once('/'));
                robots.map(|(name, _)| name.to_owned()).collect::<Vec<_>>()
            }
        };
        names.extend(self.robots.iter().flat_map(|robots| robots.robot_names()));
        names.sort();
        // A robot of the user may have the name of a built-in one, in whose place it is read.
        names.dedup();
        names
    }

    /// Names of the cell files; `NAME.matrix.toml` and similar files are behaviours.
    fn cell_names(&self) -> Vec<String> {
        let stem = |file: &str| {
            let name = file.strip_suffix(".toml")?;
            (!name.contains('.')).then(|| name.to_owned())
        };
        let dir = match &self.origin {
            Origin::Dir(dir) => dir,
            Origin::BuiltIn(files) => {
                let cells = files
                    .iter()
                    .filter_map(|(path, _)| path.strip_prefix("cells/"));
                return cells.filter_map(stem).collect();
            }
        };
        let entries = std::fs::read_dir(dir.join("cells"))
            .into_iter()
            .flatten()
            .flatten();
        entries
            .filter_map(|entry| stem(&entry.file_name().to_string_lossy()))
            .collect()
    }
}

/// Text of a file of the user.
///
/// # Errors
/// Returns [`ModelError::Read`] if it is missing, unreadable, not UTF-8 or larger than
/// [`MAX_FILE_BYTES`](user_file::MAX_FILE_BYTES).
pub fn read_text(path: &Path) -> Result<String, ModelError> {
    // Every process of a cell reads the file again, so a pipe, which can be read once, is
    // refused.
    let file = user_file::open_file(path);
    let text = file.and_then(|_| user_file::read_text(path));
    text.map_err(|error| ModelError::Read {
        file: path.display().to_string(),
        reason: error.to_string(),
        advice: "check the path".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_gives_the_files_beside_its_cells() {
        let dir = std::env::temp_dir().join(format!("robocell-data-{}", std::process::id()));
        std::fs::create_dir_all(dir.join("cells")).unwrap();
        std::fs::write(dir.join("cells/a.tree.json"), "{}").unwrap();
        let data = Data::dir(&dir);
        assert_eq!(data.read("cells/a.tree.json").unwrap(), "{}");
        assert!(data.demos().is_empty(), "a tree is no demo");
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn a_robot_that_is_not_beside_the_cells_is_a_built_in_one() {
        const BUILT_IN: Data = Data {
            origin: Origin::BuiltIn(&[
                ("robots/a/robot.toml", "built in"),
                ("robots/b/robot.toml", "built in"),
                ("cells/x.toml", "built in"),
            ]),
            robots: None,
            log: None,
        };
        let dir = std::env::temp_dir().join(format!("robocell-robots-{}", std::process::id()));
        std::fs::create_dir_all(dir.join("robots/a")).unwrap();
        std::fs::write(dir.join("robots/a/robot.toml"), "ours").unwrap();
        let data = Data::dir(&dir).with_robots_of(&BUILT_IN);
        assert_eq!(data.read("robots/a/robot.toml").unwrap(), "ours");
        assert_eq!(data.read("robots/b/robot.toml").unwrap(), "built in");
        assert!(
            data.read("robots/a/a.urdf").is_err(),
            "robots are not mixed"
        );
        assert!(data.read("cells/x.toml").is_err());
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = Data::dir("/nonexistent")
            .read("cells/reach.toml")
            .unwrap_err()
            .to_string();
        assert!(error.contains("/nonexistent/cells/reach.toml"), "{error}");
        let error = Data::files(&[("cells/reach.toml", "")])
            .read("cells/raech.toml")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("did you mean 'cells/reach.toml'?"),
            "{error}"
        );
    }
}
