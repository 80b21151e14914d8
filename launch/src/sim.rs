//! What runs inside one process is another program's work: `cell-sim`.

use std::process::Command;

use crate::child::beside;
use crate::failure::{Code, Context, Failure};

/// Runs `cell-sim` with `arguments`; its output is ours, its exit code too.
pub(crate) fn run(arguments: &[String]) -> Result<(), Failure> {
    let path = beside("cell-sim")?;
    let status = Command::new(&path)
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
                message: format!("cell-sim ended with {status}"),
            });
        }
    };
    Err(Failure::silent(code))
}
