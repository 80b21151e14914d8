//! Which program does the task of a cell.
//!
//! A task program is started as the task process of a cell, and answers what
//! `eval`, `replay --verify`, `bt`, `fsm` and `schema` ask.

use std::ffi::OsStr;
use std::io::IsTerminal as _;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use cell_model::cells::replace::Replace;
use cell_model::cells::setting::Setting;
use cell_model::{CLIENT_CONTROLLER, Cell};
use cell_run::python;
use supervisor::failure::{Code, Context, Failure};
use supervisor::programs::{beside, task_program};

use crate::asked;
use crate::say;
use crate::shell::{quoted, quoted_word};

/// The program of `cell`: the one `asked` for, else the one its cell file names;
/// `None` for the built-in one.
pub(crate) fn of_cell(
    asked: Option<&str>,
    cell: &Cell,
    data_dir: Option<&Path>,
) -> Result<Option<PathBuf>, Failure> {
    if let Some(asked) = asked {
        return find(asked, data_dir).map(Some);
    }
    let Some(name) = &cell.task.head.program else {
        return Ok(None);
    };
    if name.contains('/') {
        let refused = cell.task.checker().refuse(
            "task.program",
            format!("'{name}'"),
            "a plain name is needed; `--task` takes a path",
        );
        return Err(Failure::configuration(refused));
    }
    find(name, data_dir).map(Some)
}

/// By arm: the program with its controllers, where its cell file names one.
pub(crate) fn of_arms(
    cell: &Cell,
    data_dir: Option<&Path>,
) -> Result<Vec<Option<PathBuf>>, Failure> {
    let named = cell.arms.iter().map(|arm| arm.controller.as_deref());
    let program = |name: &str| match name {
        CLIENT_CONTROLLER => beside("fci-proc"),
        _ => find(name, data_dir),
    };
    let found = named.map(|name| name.map(program).transpose());
    found.collect()
}

/// The program `asked` for, a path or a name.
pub(crate) fn find(asked: &str, data_dir: Option<&Path>) -> Result<PathBuf, Failure> {
    // As in `--task job.py`: the working directory is not among the places.
    let here = python::is_file(Path::new(asked)) && Path::new(asked).is_file();
    if asked.contains('/') || here {
        let path = std::fs::canonicalize(asked).cannot(format!("find task program {asked}"))?;
        return is_program(&path).then_some(path).ok_or_else(|| {
            Failure::configuration(format!(
                "task program {asked} is not an executable file; `chmod +x {}` makes it one",
                quoted_word(asked)
            ))
        });
    }
    let places = places(data_dir);
    let found = places.iter().map(|place| place.join(asked));
    found.clone().find(|path| is_program(path)).ok_or_else(|| {
        let there = found.clone().find(|path| path.is_file());
        let advice = there.map_or_else(
            || {
                let folders = places
                    .iter()
                    .take(3)
                    .map(|place| place.display().to_string());
                let folders: Vec<String> = folders.collect();
                format!("looked in {} and on PATH", folders.join(", "))
            },
            |path| {
                let (shown, path) = (path.display(), quoted(&path));
                format!("{shown} is not executable; `chmod +x {path}` makes it so")
            },
        );
        Failure::configuration(format!("task program '{asked}' is missing: {advice}"))
    })
}

/// Where a program without a folder is looked for: beside the cell, beside `robocell`, then on PATH.
fn places(data_dir: Option<&Path>) -> Vec<PathBuf> {
    let mut places = Vec::new();
    if let Some(dir) = data_dir {
        places.extend([dir.join("cells"), dir.to_owned()]);
    }
    let own = std::env::current_exe().ok();
    places.extend(own.as_deref().and_then(Path::parent).map(Path::to_owned));
    let path = std::env::var_os("PATH").unwrap_or_default();
    // An empty or relative entry depends on the working directory, where any file may have the
    // name.
    places.extend(std::env::split_paths(&path).filter(|place| place.is_absolute()));
    places
}

/// Whether a file can be started: an executable, or a Python file.
fn is_program(path: &Path) -> bool {
    let runs = |mode: u32| python::is_file(path) || mode & 0o111 != 0;
    let meta = path.metadata();
    meta.is_ok_and(|meta| meta.is_file() && runs(meta.permissions().mode()))
}

/// Runs a task program with `arguments`; its output is ours, its exit code too.
pub(crate) fn run<S: AsRef<OsStr>>(program: Option<&Path>, arguments: &[S]) -> Result<(), Failure> {
    run_program(&task_program(program)?, arguments)
}

/// As [`run`], for a run that leaves the file `ended` at its end: a task that calls an
/// exit in the middle of it may do so with any code, 0 included.
pub(crate) fn run_to_its_end(
    program: Option<&Path>,
    arguments: &[String],
    ended: &Path,
) -> Result<(), Failure> {
    let path = task_program(program)?;
    let status = python::command(&path)
        .args(arguments)
        .status()
        .cannot(format!("start {}", path.display()))?;
    let result = result_of(&path, status);
    if ended.is_file() || cell_rt::signal::stop_requested() {
        return result;
    }
    // Of another version it refuses the run, and says so, with one of these.
    let is_refusal = matches!(status.code(), Some(2 | 3));
    let code = result
        .err()
        .filter(|_| is_refusal)
        .map(|failure| failure.code);
    Err(Failure {
        code: code.unwrap_or(Code::GaveUp),
        message: format!(
            "{} ended with {status} before the end of the run: a task that has to give up \
             raises an exception or fails its job, and does not end its process",
            named(&path)
        ),
    })
}

/// Replaces this process by a task program: a kill of this process ends the work.
pub(crate) fn become_it(program: Option<&Path>, arguments: &[String]) -> Failure {
    let path = match task_program(program) {
        Ok(path) => path,
        Err(failure) => return failure,
    };
    // A child would outlive a killed launcher and keep the lock of its rows (ADR 23).
    let error = python::command(&path).args(arguments).exec();
    Failure::configuration(format!("start {}: {error}", path.display()))
}

/// Runs another of our programs the same way.
pub(crate) fn run_other(program: &str, arguments: &[String]) -> Result<(), Failure> {
    run_program(&beside(program)?, arguments)
}

fn run_program<S: AsRef<OsStr>>(path: &Path, arguments: &[S]) -> Result<(), Failure> {
    let status = python::command(path)
        .args(arguments)
        .status()
        .cannot(format!("start {}", path.display()))?;
    result_of(path, status)
}

/// Asks a task program, whose output is ours and whose exit code is, too.
pub(crate) fn answer<S: AsRef<OsStr>>(
    program: Option<&Path>,
    question: &str,
    arguments: &[S],
) -> Result<(), Failure> {
    let path = task_program(program)?;
    let mut command = python::command(&path);
    command.args(arguments);
    // A file may be `/dev/stdin`. A terminal would be waited for.
    if std::io::stdin().is_terminal() {
        command.stdin(Stdio::null());
    }
    let said = asked::ask_with_input(&mut command, &named(&path), question, limit(program))?;
    result_of(&path, said.status)
}

/// What the exit code of a program of ours says; the program has said why.
fn result_of(path: &Path, status: ExitStatus) -> Result<(), Failure> {
    let code = match status.code() {
        Some(0) => return Ok(()),
        Some(2) => Code::Usage,
        Some(3) => Code::Configuration,
        Some(4) => Code::NotRunning,
        Some(5) => Code::TaskFailed,
        _ => {
            return Err(Failure::gave_up(format!(
                "{} ended with {status}",
                path.display()
            )));
        }
    };
    Err(Failure::silent(code))
}

/// A task program in a message.
fn named(path: &Path) -> String {
    format!("task program {}", path.display())
}

/// How long a task program may take for an answer.
fn limit(program: Option<&Path>) -> Duration {
    match program {
        Some(path) if python::is_file(path) => asked::IMPORTS,
        // It may be a script that builds the task first, as that of `robocell new`.
        Some(_) => asked::BUILD,
        None => asked::QUICK,
    }
}

/// What a policy is made from besides the cell: a folder, numbers in place of those of the
/// cell file, and leaves that are replaced.
pub(crate) type Files<'a> = (Option<&'a Path>, &'a [Setting], &'a [Replace]);

/// The command that asks for the picture of `policy`.
fn picture(path: &Path, demo: &str, policy: &str, (data_dir, set, replace): Files<'_>) -> Command {
    let mut command = python::command(path);
    command.args(["behaviour", "show", "bt", demo, "--policy", policy]);
    if let Some(dir) = data_dir {
        command.arg("--data").arg(dir);
    }
    for setting in set {
        command.args(["--set", &setting.to_string()]);
    }
    // A list of plain values: it can always be written as JSON.
    if let Ok(rules) = serde_json::to_string(replace)
        && !replace.is_empty()
    {
        command.args(["--replace", &rules]);
    }
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The drawing of `policy`, if a task with it can be made from the files as they are
/// now: the task program says so before anything that runs is stopped for it.
pub(crate) fn check_policy(
    program: Option<&Path>,
    demo: &str,
    policy: &str,
    files: Files<'_>,
) -> Result<String, Failure> {
    let path = task_program(program)?;
    let mut command = picture(&path, demo, policy, files);
    // What a Python file says is answered to the page, too, which does not see a terminal.
    let is_seen = program.is_some_and(|program| !python::is_file(program));
    if is_seen {
        // It may be built first, which takes its time and has to be seen.
        command.stderr(Stdio::inherit());
    }
    let question = format!("policy '{policy}' of demo '{demo}'");
    let said = asked::ask(&mut command, &named(&path), &question, limit(program))?;
    let text = String::from_utf8_lossy(&said.stderr);
    let text = text.trim();
    if said.status.success() {
        // Warnings of Python.
        text.lines().for_each(say::warn);
        return Ok(String::from_utf8_lossy(&said.stdout).into_owned());
    }
    let why = match (is_seen, said.status) {
        (false, _) if !text.is_empty() => return Err(Failure::configuration(text)),
        (true, _) => "see above".to_owned(),
        (false, status) => format!("it ended with {status} and wrote nothing"),
    };
    Err(Failure::configuration(format!(
        "{} does not take demo '{demo}' with policy '{policy}': {why}",
        named(&path)
    )))
}

/// Names of the nodes and states of `policy`.
pub(crate) fn node_names(
    program: Option<&Path>,
    demo: &str,
    policy: &str,
    data_dir: Option<&Path>,
) -> Result<Vec<String>, Failure> {
    let path = task_program(program)?;
    let mut command = picture(&path, demo, policy, (data_dir, &[], &[]));
    command.args(["--format", "names"]);
    let question = format!("the nodes of policy '{policy}'");
    let said = asked::ask(&mut command, &named(&path), &question, limit(program))?;
    let text = String::from_utf8_lossy(&said.stdout);
    let is_good = said.status.success();
    Ok(text
        .lines()
        .filter(|_| is_good)
        .map(str::to_owned)
        .collect())
}
