//! Why a command ended, and the exit code that says so.

use std::fmt;
use std::process::ExitCode;

/// The documented exit codes other than 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// The command line was wrong.
    Usage = 2,
    /// Something in a file, a name or the machine was wrong, or the cell runs already.
    Configuration = 3,
    /// No cell of that name runs.
    NotRunning = 4,
    /// The task failed or ran out of time.
    TaskFailed = 5,
    /// A process could not be kept running.
    GaveUp = 6,
    /// A gate: the second is worse than the first.
    Worse = 7,
}

/// A command that did not end well: one clear message and an exit code.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Which exit code.
    pub code: Code,
    /// What to tell the person; empty when everything is said already.
    pub message: String,
}

impl Failure {
    /// Something in a file, a name or the machine is wrong.
    pub fn configuration(message: impl fmt::Display) -> Self {
        Self {
            code: Code::Configuration,
            message: message.to_string(),
        }
    }

    /// A process could not be kept running.
    pub fn gave_up(message: impl fmt::Display) -> Self {
        Self {
            code: Code::GaveUp,
            message: message.to_string(),
        }
    }

    /// Something on the command line is wrong.
    pub fn usage(message: impl fmt::Display) -> Self {
        Self {
            code: Code::Usage,
            message: message.to_string(),
        }
    }

    /// Nothing runs.
    pub fn not_running(cell: &str) -> Self {
        let message = format!(
            "no cell `{cell}` is running; `robocell run DEMO --cell {cell}` starts one, `robocell list` shows the running cells"
        );
        Self {
            code: Code::NotRunning,
            message,
        }
    }

    /// Ends with `code` without another word.
    pub fn silent(code: Code) -> Self {
        Self {
            code,
            message: String::new(),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl From<Code> for ExitCode {
    fn from(code: Code) -> Self {
        Self::from(code as u8)
    }
}

/// Adds what was being done to an input/output error.
pub trait Context<T> {
    /// `what` as in "cannot {what}: {error}".
    fn cannot(self, what: impl fmt::Display) -> Result<T, Failure>;
}

impl<T, E: fmt::Display> Context<T> for Result<T, E> {
    fn cannot(self, what: impl fmt::Display) -> Result<T, Failure> {
        self.map_err(|error| Failure::configuration(format!("cannot {what}: {error}")))
    }
}
