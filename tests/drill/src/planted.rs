//! Planted bugs: changes of the code that the drill has to find.
//!
//! A copy of the tree gets the changes and is built, and its drill runs until an invariant
//! fails. All copies are one directory and share their build. A bug whose text asks for
//! [`SWITCH`] can be off: those are built once, all together, and each is on in its own search.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Instant;

use serde::{Deserialize, Serialize};

/// In the text of a bug: whether it is on.
pub const SWITCH: &str = "PLANTED";
/// Variable with the number of the bug that is on.
const VARIABLE: &str = "ROBOCELL_PLANTED";

/// A bug.
#[derive(Clone, Debug, Deserialize)]
pub struct Bug {
    /// What it breaks, for people.
    pub about: String,
    /// Its first change.
    #[serde(flatten)]
    pub change: Change,
    /// The others.
    #[serde(default)]
    pub more: Vec<Change>,
}

/// A change of one place of the code.
#[derive(Clone, Debug, Deserialize)]
pub struct Change {
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
    /// Plans until then.
    pub plans: u64,
    /// Processor time of the search (s).
    pub processor_s: f64,
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

impl Change {
    /// The text of the file with the change, of the bug called `name`.
    ///
    /// # Errors
    /// In words, where the text does not occur exactly once.
    pub fn of(&self, name: &str, text: &str) -> Result<String, String> {
        let is_on = format!(
            "(*{{ static ON: std::sync::OnceLock<bool> = std::sync::OnceLock::new(); \
             ON.get_or_init(|| std::env::var(\"{VARIABLE}\").is_ok_and(|on| on == \"{name}\")) }})"
        );
        match text.matches(&self.from).count() {
            1 => Ok(text.replacen(&self.from, &self.to.replace(SWITCH, &is_on), 1)),
            count => Err(say(
                &self.file,
                format_args!("{count} places have the text of bug {name}, not one"),
            )),
        }
    }
}

impl Bug {
    /// Its changes.
    pub fn changes(&self) -> impl Iterator<Item = &Change> {
        std::iter::once(&self.change).chain(&self.more)
    }

    /// Whether it can be off.
    pub fn has_switch(&self) -> bool {
        self.changes().all(|change| change.to.contains(SWITCH))
    }

    fn plant(&self, tree: &Path, name: &str) -> Result<(), String> {
        for change in self.changes() {
            let path = tree.join(&change.file);
            let text = std::fs::read_to_string(&path).map_err(|error| say(&path, error))?;
            std::fs::write(&path, change.of(name, &text)?).map_err(|error| say(&path, error))?;
        }
        Ok(())
    }
}

/// Builds the tree with `bugs` and searches for each of them, for at most `minutes`; `each` gets
/// what was found.
///
/// # Errors
/// In words, where a change does not fit or does not compile.
pub fn search_all(
    bugs: &[(u32, Bug)],
    minutes: f64,
    mut each: impl FnMut(Found) -> Result<(), String>,
) -> Result<(), String> {
    let (switched, others): (Vec<_>, Vec<_>) = bugs.iter().partition(|(_, bug)| bug.has_switch());
    let alone = others.into_iter().map(|bug| vec![bug]);
    for together in std::iter::once(switched).chain(alone) {
        if together.is_empty() {
            continue;
        }
        let tree = copy_of_tree()?;
        for (number, bug) in &together {
            bug.plant(&tree, &number.to_string())?;
        }
        build(&tree)?;
        for (number, _) in together {
            each(search(&tree, &number.to_string(), minutes)?)?;
        }
    }
    Ok(())
}

/// Searches the tree with the changes of the patch file at `patch`.
///
/// # Errors
/// As [`search_all`].
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
    build(&tree)?;
    search(&tree, &patch.display().to_string(), minutes)
}

/// A copy of the files of the checkout; files that are equal keep their time, for cargo.
fn copy_of_tree() -> Result<PathBuf, String> {
    let tree = root().join("target/drill/tree");
    let mut git = Command::new("git");
    git.current_dir(root())
        .args(["ls-files", "-z", "--cached", "--others"]);
    let listed = run(git.arg("--exclude-standard"))?.stdout;
    let listed = String::from_utf8_lossy(&listed);
    remove_others(&tree, &tree, &listed.split_terminator('\0').collect())?;
    for name in listed.split_terminator('\0') {
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

/// Removes the files below `dir` that are not `listed` by their path from `tree`: those of an earlier
/// copy that have moved.
fn remove_others(tree: &Path, dir: &Path, listed: &BTreeSet<&str>) -> Result<(), String> {
    let Ok(entries) = std::fs::read_dir(dir) else {
        return Ok(());
    };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.strip_prefix(tree).ok().and_then(Path::to_str);
        if path.is_dir() {
            remove_others(tree, &path, listed)?;
        } else if name.is_none_or(|name| !listed.contains(name)) {
            std::fs::remove_file(&path).map_err(|error| say(&path, error))?;
        }
    }
    Ok(())
}

/// The drill of the copy of the tree.
fn program() -> PathBuf {
    target().join("thin/robocell-drill")
}

fn target() -> PathBuf {
    root().join("target/drill/target")
}

fn build(tree: &Path) -> Result<(), String> {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(tree).env("CARGO_TARGET_DIR", target());
    run(cargo
        .args(["build", "--profile", "thin", "--quiet"])
        .args(["--package", "robocell-drill"]))?;
    Ok(())
}

fn search(tree: &Path, name: &str, minutes: f64) -> Result<Found, String> {
    let began = Instant::now();
    // First where a plan costs least: as many schedules as possible.
    let (mut plans, mut processor_s, mut first) = (0, 0.0, None);
    for (level, part) in [("loops", 0.4), ("mixed", 0.6)] {
        let mut drill = Command::new(program());
        drill.args(["--first", "--json", "--level", level, "--minutes"]);
        drill.arg((part * minutes).to_string()).current_dir(tree);
        let output = drill.env(VARIABLE, name).output();
        let output = output.map_err(|error| error.to_string())?;
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let line = text.lines().last().unwrap_or_default();
        let summary: serde_json::Value = serde_json::from_str(line).unwrap_or_default();
        plans += summary["schedules"].as_u64().unwrap_or(0);
        processor_s += summary["processor_s"].as_f64().unwrap_or(0.0);
        if output.status.code() == Some(5) {
            first = Some(summary["failed"][0].clone());
            break;
        }
    }
    let number = |key: &str| first.as_ref().and_then(|first| first[key].as_u64());
    Ok(Found {
        bug: name.to_owned(),
        found: first.is_some(),
        invariant: number("invariant").and_then(|n| u32::try_from(n).ok()),
        plans,
        processor_s,
        seconds: began.elapsed().as_secs_f64(),
        seed: number("seed"),
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
