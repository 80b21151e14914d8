//! The file of the policy of a live cell: read for the page, checked, and replaced
//! (docs/page-protocol.md, `/api/policy`).
//!
//! A page edits a program that moves an arm. So the text is checked by the task program itself,
//! with the whole cell in a copy, before it replaces the file; the file is always the one the
//! cell names, below `cells/`; a page gives no path.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use cell_model::data::read_text;
use cell_model::draft;
use cell_model::user_file::MAX_FILE_BYTES;
use cell_run::spec::RunSpec;
use serde::Serialize;
use serde_json::{Value, json};

/// Name of the built-in task program, beside this one.
const TASK_PROGRAM: &str = "task-proc";
/// Levels of folders in `cells/` that are searched.
// Links could lead in circles otherwise.
const MAX_DEPTH: usize = 4;

/// Kinds of files a policy can be written in.
const KINDS: [Kind; 3] = [
    Kind {
        policy: "json",
        word: "tree",
        ending: ".tree.json",
        language: "json",
        schema: "tree",
    },
    Kind {
        policy: "table",
        word: "table",
        ending: ".machine.toml",
        language: "toml",
        schema: "machine",
    },
    Kind {
        policy: "matrix",
        word: "matrix",
        ending: ".matrix.toml",
        language: "toml",
        schema: "machine",
    },
];

#[derive(Clone, Copy, Debug)]
struct Kind {
    /// Name of the policies written in this kind of file.
    policy: &'static str,
    /// As the page knows it.
    word: &'static str,
    ending: &'static str,
    language: &'static str,
    /// Its schema, as `robocell schema` names it.
    schema: &'static str,
}

/// A defect of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// From 1 up; 0 if the place is unknown.
    line: u32,
    column: u32,
    message: String,
}

impl Fault {
    /// A defect without a place.
    pub fn without_place(message: String) -> Self {
        Self {
            line: 0,
            column: 0,
            message,
        }
    }
}

/// The policies of a live cell.
#[derive(Clone, Debug)]
pub struct PolicyFiles {
    demo: String,
    /// The folder with `cells/` and `robots/` of the run.
    data: PathBuf,
    /// Whether the folder is the user's.
    writable: bool,
    program: Option<PathBuf>,
    /// Folder for a text that is being checked.
    scratch: PathBuf,
}

/// One file.
#[derive(Debug)]
struct PolicyFile {
    kind: Kind,
    /// Below `cells/`.
    name: PathBuf,
}

impl PolicyFiles {
    /// The policies of the run of `spec`.
    pub fn new(spec: &RunSpec) -> Self {
        let data = spec.data_dir.as_ref().unwrap_or(&spec.built_in_dir);
        // Beside this program, as both are of one build; a path
        // from the environment might not be.
        let beside = std::env::current_exe().ok();
        let beside = beside.and_then(|own| Some(own.parent()?.join(TASK_PROGRAM)));
        Self {
            demo: spec.demo.clone(),
            data: data.clone(),
            writable: spec.data_dir.is_some(),
            program: spec.task_program.clone().or(beside),
            // In the run directory, which is private and deleted with the run.
            scratch: spec.run_dir.join("edit"),
        }
    }

    /// The file of `policy` as shown on the page.
    pub fn read(&self, policy: &str) -> Value {
        let shown = self.find(policy).and_then(|file| {
            let text = read_text(&self.path(&file)).map_err(|error| error.to_string())?;
            Ok((file, text))
        });
        match shown {
            // Without a file the page shows the reason, not an error.
            Err(why) => json!({ "kind": null, "name": null, "why": why }),
            Ok((file, text)) => json!({
                "kind": file.kind.word,
                "name": format!("cells/{}", file.name.display()),
                "text": text,
                "language": file.kind.language,
                "schema": self.schema(file.kind.schema),
                "writable": self.writable,
                "why": "",
            }),
        }
    }

    /// Checks that a task can be made of `text` in place of the file of `policy`.
    ///
    /// # Errors
    /// The defects found.
    pub fn check(&self, policy: &str, text: &str) -> Result<(), Vec<Fault>> {
        let file = self.find(policy).map_err(unplaced)?;
        let out = self.try_out(policy, &file, text).map_err(unplaced)?;
        if out.status.success() {
            return Ok(());
        }
        // The text was in a temporary folder; the reader of the
        // message knows the file's own name.
        let output = String::from_utf8_lossy(&out.stderr);
        let output = output.replace(&format!("{}/", self.scratch.display()), "");
        Err(faults(&output, &format!("cells/{}:", file.name.display())))
    }

    /// Writes `text`, which was checked, into the file of `policy`; returns a message for the
    /// person.
    ///
    /// # Errors
    /// The reason why it was not written.
    pub fn write(&self, policy: &str, text: &str) -> Result<String, String> {
        let file = self.find(policy)?;
        let path = self.path(&file);
        draft::replace(&path, text.as_bytes(), 0o644)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(if self.writable {
            format!("saved to {}", path.display())
        } else {
            "it is used until this cell ends; `robocell run --data DIR` keeps it".to_owned()
        })
    }

    /// Runs the task program on a copy of the cell with `text`.
    fn try_out(&self, policy: &str, file: &PolicyFile, text: &str) -> Result<Output, String> {
        let wrong = |error: std::io::Error| format!("{}: {error}", self.scratch.display());
        // Left by a monitor that was killed here; a stale file must not take part in the check.
        match fs::remove_dir_all(&self.scratch) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(wrong(error)),
            _ => {}
        }
        // Copied, not linked: the new text must not reach the
        // running cell before it is checked.
        let cells = self.scratch.join("cells");
        copy(&self.data.join("cells"), &cells, MAX_DEPTH).map_err(wrong)?;
        // Robots are only read, so a link is enough.
        symlink(self.data.join("robots"), self.scratch.join("robots")).map_err(wrong)?;
        fs::write(cells.join(&file.name), text).map_err(wrong)?;
        let out = self.run(&[
            "behaviour".as_ref(),
            "show".as_ref(),
            "bt".as_ref(),
            self.demo.as_ref(),
            "--policy".as_ref(),
            policy.as_ref(),
            "--data".as_ref(),
            self.scratch.as_os_str(),
        ]);
        // The next check creates it again.
        let _removed = fs::remove_dir_all(&self.scratch).is_ok();
        out
    }

    // Without a schema the editor still works, only without suggestions.
    fn schema(&self, what: &str) -> Value {
        let out = self.run(&["schema".as_ref(), what.as_ref()]).ok();
        let out = out.filter(|out| out.status.success());
        out.and_then(|out| serde_json::from_slice(&out.stdout).ok())
            .unwrap_or_default()
    }

    fn run(&self, arguments: &[&std::ffi::OsStr]) -> Result<Output, String> {
        let program = self.program.as_ref();
        let program = program.ok_or("the task program was not found")?;
        Command::new(program)
            .args(arguments)
            .output()
            .map_err(|error| format!("{}: {error}", program.display()))
    }

    fn path(&self, file: &PolicyFile) -> PathBuf {
        self.data.join("cells").join(&file.name)
    }

    /// The file of `policy`: the one of its kind named in the cell file, or the one with the
    /// name of the demo.
    fn find(&self, policy: &str) -> Result<PolicyFile, String> {
        let kind = KINDS.into_iter().find(|kind| kind.policy == policy);
        let Some(kind) = kind else {
            return Err(format!("policy {policy} is written in code, not in a file"));
        };
        let cells = self.data.join("cells");
        let own = format!("{}{}", self.demo, kind.ending);
        // The file that the cell names comes first: it is the one the task reads.
        let named = self.named_in_cell(&cells, kind.ending);
        let places = named
            .into_iter()
            .chain([PathBuf::from(&own), Path::new(&self.demo).join(&own)]);
        let found = places.into_iter().find(|name| {
            // A cell file is data of the user, but a page must not
            // read outside of `cells/` by way of it.
            let inside = !name.is_absolute() && !name.components().any(|c| c.as_os_str() == "..");
            inside && cells.join(name).is_file()
        });
        let name = found.ok_or_else(|| {
            let (demo, ending) = (&self.demo, kind.ending);
            format!("no file of policy {policy} was found: cells/{demo}.toml names none that ends in {ending}")
        })?;
        Ok(PolicyFile { kind, name })
    }

    fn named_in_cell(&self, cells: &Path, ending: &str) -> Vec<PathBuf> {
        let text = read_text(&cells.join(format!("{}.toml", self.demo))).unwrap_or_default();
        let table: toml::Table = text.parse().unwrap_or_default();
        let mut names = Vec::new();
        if let Some(task) = table.get("task") {
            strings(task, &mut |text| {
                if text.ends_with(ending) {
                    names.push(PathBuf::from(text));
                }
            });
        }
        names
    }
}

fn strings(value: &toml::Value, take: &mut impl FnMut(&str)) {
    match value {
        toml::Value::String(text) => take(text),
        toml::Value::Array(all) => all.iter().for_each(|one| strings(one, take)),
        toml::Value::Table(all) => all.values().for_each(|one| strings(one, take)),
        _ => {}
    }
}

/// Copies the regular files of a folder; links and files too large for a cell are left out.
fn copy(from: &Path, to: &Path, depth: usize) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)?.flatten() {
        let (kind, target) = (entry.file_type()?, to.join(entry.file_name()));
        if kind.is_dir() && depth > 0 {
            copy(&entry.path(), &target, depth - 1)?;
        } else if kind.is_file() && entry.metadata()?.len() <= MAX_FILE_BYTES {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}

fn unplaced(message: String) -> Vec<Fault> {
    vec![Fault::without_place(message)]
}

/// The lines of the task program's output; those about the file start with `prefix`, line and
/// column.
fn faults(output: &str, prefix: &str) -> Vec<Fault> {
    let fault = |line: &str| {
        let placed = line.strip_prefix(prefix).and_then(|rest| {
            let mut parts = rest.splitn(3, ':');
            let (line, column) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
            let message = parts.next()?.trim().to_owned();
            Some(Fault {
                line,
                column,
                message,
            })
        });
        placed.unwrap_or_else(|| Fault::without_place(line.trim().to_owned()))
    };
    let found: Vec<Fault> = output
        .lines()
        .filter(|line| !line.trim().is_empty())
        .map(fault)
        .collect();
    // A refusal always has a message: an empty list of faults would look like success.
    if found.is_empty() {
        return unplaced("the task program refused it without a word".to_owned());
    }
    found
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    #[test]
    fn errors_of_the_file_have_their_place_and_others_none() {
        let output = "cells/a.tree.json:32:26: unknown node type 'X'\n\ncells/a.toml: no\n";
        let found = faults(output, "cells/a.tree.json:");
        assert_eq!(
            found[0],
            Fault {
                line: 32,
                column: 26,
                message: "unknown node type 'X'".to_owned()
            }
        );
        assert_eq!(
            (found[1].line, found[1].message.as_str()),
            (0, "cells/a.toml: no")
        );
        assert_eq!(faults("", "x:").len(), 1);
    }

    #[test]
    fn the_file_is_the_one_the_cell_names_and_lies_within_cells() {
        let dir = tempfile::tempdir().unwrap();
        let cells = dir.path().join("cells");
        fs::create_dir(&cells).unwrap();
        fs::write(dir.path().join("other.tree.json"), "{}").unwrap();
        fs::write(cells.join("my.tree.json"), "{}").unwrap();
        let files = PolicyFiles {
            demo: "own".to_owned(),
            data: dir.path().to_owned(),
            writable: true,
            program: None,
            scratch: dir.path().join("edit"),
        };
        assert!(files.find("json").is_err() && files.find("fsm").unwrap_err().contains("code"));
        let cell = |name: &str| {
            let text = format!("[task]\nkind = 'own'\n[task.x]\nbehaviour = '{name}'\n");
            fs::write(cells.join("own.toml"), text).unwrap();
        };
        cell("../other.tree.json");
        assert!(files.find("json").is_err());
        cell("my.tree.json");
        assert_eq!(files.find("json").unwrap().name, Path::new("my.tree.json"));
        let message = files.write("json", "{ }").unwrap();
        assert!(message.starts_with("saved to"), "{message}");
        assert_eq!(files.read("json")["text"], "{ }");
        // A file of a repository, to which the folder of the cell has a link.
        let there = dir.path().join("there.json");
        fs::rename(cells.join("my.tree.json"), &there).unwrap();
        symlink(&there, cells.join("my.tree.json")).unwrap();
        fs::set_permissions(&there, fs::Permissions::from_mode(0o640)).unwrap();
        fs::write(cells.join("my.tree.draft"), "mine").unwrap();
        files.write("json", "{}").unwrap();
        assert!(cells.join("my.tree.json").is_symlink());
        assert_eq!(fs::read_to_string(&there).unwrap(), "{}");
        let mode = there.metadata().unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        let beside = fs::read_to_string(cells.join("my.tree.draft"));
        assert_eq!(beside.unwrap(), "mine");
    }
}
