//! What runs inside one process is the work of the task program.

use std::path::Path;
use std::process::Command;

use crate::child::beside;
use crate::failure::{Code, Context, Failure};

/// The built-in task program.
const TASK_PROGRAM: &str = "task-proc";

/// Runs the task program with `arguments`; its output is ours, its exit code too.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    run_program(&beside(TASK_PROGRAM)?, arguments)
}

/// Runs another of our programs the same way.
pub(crate) fn run_other(program: &str, arguments: &[String]) -> Result<(), Failure> {
    run_program(&beside(program)?, arguments)
}

fn run_program(path: &Path, arguments: &[String]) -> Result<(), Failure> {
    let status = Command::new(path)
        .args(arguments)
        .status()
        .cannot(format!("start {}", path.display()))?;
    let code = match status.code() {
        Some(0) => return Ok(()),
        Some(2) => Code::Usage,
        Some(3) => Code::Configuration,
        Some(4) => Code::NotRunning,
        Some(5) => Code::TaskFailed,
        _ => {
            return Err(Failure {
                code: Code::GaveUp,
                message: format!("{} ended with {status}", path.display()),
            });
        }
    };
    Err(Failure::silent(code))
}

/// Whether a task with `policy` can be made from the files as they are now: the
/// task program says so before anything that runs is stopped for it.
pub(crate) fn check_policy(
    demo: &str,
    policy: &str,
    data_dir: Option<&Path>,
) -> Result<(), Failure> {
    let path = beside(TASK_PROGRAM)?;
    let mut command = Command::new(&path);
    command.args(["behaviour", "show", "bt", demo, "--policy", policy]);
    if let Some(dir) = data_dir {
        command.arg("--data").arg(dir);
    }
    let said = command
        .output()
        .cannot(format!("start {}", path.display()))?;
    if said.status.success() {
        return Ok(());
    }
    let text = String::from_utf8_lossy(&said.stderr);
    Err(Failure::configuration(text.trim()))
}
