//! Task programs written in Python, and the command that starts them.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

/// Environment variable with the Python interpreter of task files. The `robocell` of the Python
/// package sets it to the interpreter in which it is installed.
pub const ENV_PYTHON: &str = "ROBOCELL_PYTHON";

/// The interpreter if [`ENV_PYTHON`] is not set.
const PYTHON: &str = "python3";

/// Whether a task program is a Python file.
pub fn is_file(program: &Path) -> bool {
    program
        .extension()
        .is_some_and(|extension| extension == "py")
}

/// Name of the policy of a Python file if the user gives none: that of the file, in at most
/// `most` bytes.
pub fn policy_name(file: &Path, most: usize) -> String {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let mut end = stem.len().min(most);
    // A character is not cut in half: the name would not be UTF-8.
    while !stem.is_char_boundary(end) {
        end -= 1;
    }
    stem.get(..end).unwrap_or_default().to_owned()
}

/// The command that starts a task program; the caller adds its arguments.
pub fn command(program: &Path) -> Command {
    if !is_file(program) {
        return Command::new(program);
    }
    let mut command = Command::new(interpreter());
    command.args(["-m", "robocell.task"]).arg(program);
    command
}

/// The Python interpreter of task files.
pub fn interpreter() -> OsString {
    // Empty counts as not set: a command without a name cannot be started.
    let named = std::env::var_os(ENV_PYTHON).filter(|name| !name.is_empty());
    named.unwrap_or_else(|| PYTHON.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_python_file_is_run_by_an_interpreter_and_another_program_by_itself() {
        let words = |path: &str| {
            let command = command(Path::new(path));
            let arguments = command.get_args().map(|a| a.to_string_lossy().into_owned());
            arguments.collect::<Vec<_>>()
        };
        assert_eq!(words("/a/job.py"), ["-m", "robocell.task", "/a/job.py"]);
        assert!(words("/a/job").is_empty());
    }

    #[test]
    fn a_policy_is_called_like_its_file_and_fits_a_decision() {
        assert_eq!(policy_name(Path::new("/a/sort_cubes.py"), 16), "sort_cubes");
        assert_eq!(policy_name(Path::new("ääääääääääääää.py"), 15).len(), 14);
    }
}
