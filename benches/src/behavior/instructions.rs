//! Instructions, counted by valgrind: the number is the same on a loaded machine. The
//! difference of a short and a long run leaves out the start.

use std::process::Command;

use crate::report::Row;

use super::subject::Subject;

/// Suffix of the rows that count instructions.
pub(crate) const SUFFIX: &str = ", instructions";
const SHORT: u64 = 2_000;
const LONG: u64 = 12_000;

/// Instructions of each subject's work.
///
/// # Errors
/// The reason why there are none.
pub(crate) fn rows(all: &[Subject]) -> Result<Vec<Row>, String> {
    if Command::new("valgrind").arg("--version").output().is_err() {
        return Err("valgrind is not installed".to_owned());
    }
    all.iter().map(row).collect()
}

fn row(subject: &Subject) -> Result<Row, String> {
    // The start of the program is the same in both runs and cancels out.
    let (short, long) = (run(subject.name, SHORT)?, run(subject.name, LONG)?);
    let each = long.saturating_sub(short) as f64 / (LONG - SHORT) as f64;
    let name = format!("{}{SUFFIX}", subject.name);
    Ok(Row::new(name, 1, [each; 4]).in_unit("instructions"))
}

/// Instructions of a whole run of this program.
fn run(row: &str, times: u64) -> Result<u64, String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(own)
        .args(["behavior", "--only", row, &times.to_string()])
        .output()
        .map_err(|error| format!("valgrind does not start: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        let last = said.lines().last().unwrap_or_default();
        return Err(format!("valgrind ended with {}: {last}", output.status));
    }
    let collected = said.lines().find_map(|line| {
        let (_, count) = line.split_once("Collected : ")?;
        count.trim().parse().ok()
    });
    collected.ok_or_else(|| "valgrind counted nothing".to_owned())
}
