//! Planted bugs: changes of the code that the drill has to find.
//!
//! A copy of the tree gets the change and is built, and its drill runs until an invariant
//! fails. All copies are one directory and share their build.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

use serde::{Deserialize, Serialize};

/// A change of one place of the code.
#[derive(Clone, Debug, Deserialize)]
pub struct Bug {
    /// What it breaks, for people.
    pub about: String,
    /// The file.
    pub file: PathBuf,
    /// Text that the file has exactly once.
    pub from: String,
    /// Its replacement.
    pub to: String,
}

/// Whether a bug was found.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// Its number, or the name of a patch.
    pub bug: String,
    /// Whether an invariant failed.
    pub found: bool,
    /// Which.
    pub invariant: Option<u32>,
    /// Time of the search (s).
    pub seconds: f64,
    /// The seed of the first plan that failed.
    pub seed: Option<u64>,
}

/// The root of the checkout.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The planted bugs by number.
///
/// # Errors
/// In words, for a file that cannot be read.
pub fn all() -> Result<Vec<(u32, Bug)>, String> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("planted");
    let read = |path: &Path| std::fs::read_to_string(path).map_err(|error| say(path, error));
    let files = std::fs::read_dir(&dir).map_err(|error| say(&dir, error))?;
    let mut bugs = Vec::new();
    for file in files {
        let path = file.map_err(|error| say(&dir, error))?.path();
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        let number = stem.and_then(|stem| stem.parse().ok());
        let number = number.ok_or_else(|| say(&path, "its name is not a number"))?;
        let bug = toml::from_str(&read(&path)?).map_err(|error| say(&path, error))?;
        bugs.push((number, bug));
    }
    bugs.sort_by_key(|(number, _)| *number);
    Ok(bugs)
}

fn say(path: &Path, error: impl std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

impl Bug {
    /// The text of `file` with the change.
    ///
    /// # Errors
    /// In words, where the text does not occur exactly once.
    pub fn change(&self, text: &str) -> Result<String, String> {
        match text.matches(&self.from).count() {
            1 => Ok(text.replacen(&self.from, &self.to, 1)),
            count => Err(say(
                &self.file,
                format_args!(
                    "{count} places have the text of \"{}\", not one",
                    self.about
                ),
            )),
        }
    }

    /// Builds the tree with this bug and searches for at most `minutes`.
    ///
    /// # Errors
    /// In words, where the change does not fit or does not compile.
    pub fn search(&self, name: &str, minutes: f64) -> Result<Found, String> {
        let tree = copy_of_tree()?;
        let path = tree.join(&self.file);
        let text = std::fs::read_to_string(&path).map_err(|error| say(&path, error))?;
        std::fs::write(&path, self.change(&text)?).map_err(|error| say(&path, error))?;
        search(&tree, name, minutes)
    }
}

/// Searches the tree with the changes of the patch file at `patch`.
///
/// # Errors
/// As [`Bug::search`].
pub fn search_patch(patch: &Path, minutes: f64) -> Result<Found, String> {
    let patch = patch.canonicalize().map_err(|error| say(patch, error))?;
    let tree = copy_of_tree()?;
    let mut git = Command::new("git");
    // As a directory outside of a repository: within one, paths are those of its root, and a patch
    // of other paths changes nothing.
    let above = tree
        .join("..")
        .canonicalize()
        .map_err(|error| say(&tree, error))?;
    git.env("GIT_CEILING_DIRECTORIES", above).current_dir(&tree);
    run(git.args(["apply", "--whitespace=nowarn"]).arg(&patch))?;
    search(&tree, &patch.display().to_string(), minutes)
}

/// A copy of the files of the checkout; files that are equal keep their time, for cargo.
fn copy_of_tree() -> Result<PathBuf, String> {
    let tree = root().join("target/drill/tree");
    let mut git = Command::new("git");
    git.current_dir(root())
        .args(["ls-files", "-z", "--cached", "--others"]);
    let listed = run(git.arg("--exclude-standard"))?.stdout;
    for name in String::from_utf8_lossy(&listed).split_terminator('\0') {
        let (from, to) = (root().join(name), tree.join(name));
        // A file that was removed and not committed is listed, too.
        let Ok(bytes) = std::fs::read(&from) else {
            continue;
        };
        if std::fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let dir = to.parent().unwrap_or(&tree);
        std::fs::create_dir_all(dir).map_err(|error| say(dir, error))?;
        std::fs::write(&to, bytes).map_err(|error| say(&to, error))?;
    }
    Ok(tree)
}

fn search(tree: &Path, name: &str, minutes: f64) -> Result<Found, String> {
    let target = root().join("target/drill/target");
    let mut cargo = Command::new("cargo");
    cargo.current_dir(tree).env("CARGO_TARGET_DIR", &target);
    run(cargo.args([
        "build",
        "--release",
        "--quiet",
        "--package",
        "robocell-drill",
    ]))?;
    let began = Instant::now();
    // First where a plan costs least: as many schedules as possible.
    let mut found = None;
    for (level, part) in [("loops", 0.4), ("mixed", 0.6)] {
        let mut drill = Command::new(target.join("release/robocell-drill"));
        drill.args(["--first", "--json", "--level", level, "--minutes"]);
        drill.arg((part * minutes).to_string()).current_dir(tree);
        let output = drill.output().map_err(|error| error.to_string())?;
        if output.status.code() == Some(5) {
            found = Some(output.stdout);
            break;
        }
    }
    let text = String::from_utf8_lossy(found.as_deref().unwrap_or_default()).into_owned();
    let line = text.lines().last().unwrap_or_default();
    let summary: serde_json::Value = serde_json::from_str(line).unwrap_or_default();
    let first = &summary["failed"][0];
    Ok(Found {
        bug: name.to_owned(),
        found: found.is_some(),
        invariant: first["invariant"]
            .as_u64()
            .and_then(|n| u32::try_from(n).ok()),
        seconds: began.elapsed().as_secs_f64(),
        seed: first["seed"].as_u64(),
    })
}

fn run(command: &mut Command) -> Result<Output, String> {
    let output = command
        .output()
        .map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        return Ok(output);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(format!("{command:?}: {said}"))
}
