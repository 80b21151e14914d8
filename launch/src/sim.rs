//! What runs inside one process is another program's work: `cell-sim`.

use std::path::Path;
use std::process::Command;

use crate::child::beside;
use crate::failure::{Code, Context, Failure};

/// Runs `cell-sim` with `arguments`; its output is ours, its exit code too.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    run_program(&beside("cell-sim")?, arguments)
}

/// Runs another of our programs the same way.
pub(crate) fn run_other(program: &str, arguments: &[String]) -> Result<(), Failure> {
    run_program(&beside(program)?, arguments)
}

/// Runs the bench of behaviours. It is an example of `cell-sim`, as the
/// libraries it measures against are no dependencies of a cell.
pub(crate) fn behavior_bench(json: bool) -> Result<(), Failure> {
    let own = std::env::current_exe().map_err(Failure::configuration)?;
    let path = own.with_file_name("examples").join("bench_behavior");
    if !path.is_file() {
        return Err(Failure::configuration(format!(
            "{} is missing: this bench is built on its own, in a checkout; \
             `cargo build --release -p cell-sim --example bench_behavior` builds it",
            path.display()
        )));
    }
    let arguments: Vec<String> = json.then(|| "--json".to_owned()).into_iter().collect();
    run_program(&path, &arguments)
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

/// Whether a task with `policy` can be made from the files as they are now:
/// found out by another program before anything that runs is stopped for it.
pub(crate) fn check_policy(
    demo: &str,
    policy: &str,
    data_dir: Option<&Path>,
) -> Result<(), Failure> {
    let path = beside("cell-sim")?;
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
    let text = text.trim().trim_start_matches("cell-sim: ");
    Err(Failure::configuration(text))
}
