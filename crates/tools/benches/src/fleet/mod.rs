//! `robocell bench fleet`: the cost of many cells, and its growth with the size of one.
//!
//! Memory of a cell; cells that a core carries in lockstep; episodes per second over jobs; time
//! to start an episode; the tick over the size of a cell, with the exponent; last, cells of
//! processes in real time, one more at a time.

mod cost;
mod fit;
mod lockstep;
mod memory;
mod real_time;
pub(crate) mod scenes;
mod start;

use std::path::PathBuf;

use crate::error::FleetError;
use crate::report::Report;

/// The demo, unless another one is named.
const DEMO: &str = "franka-stack";

const NOTES: [&str; 5] = [
    "lockstep: simulated seconds in a second of processor time, of a cell of franka-stack",
    "start: a reset takes from the request to the tick in which all processes have seen it",
    "tick over size: mean tick of ten, with one decision; an arm of reach holds",
    "real time: lateness p99 of the later loop, controller or physics; below 50 us it counts as 50 us",
    "exponent k: cost(n) - cost(0) = b n^k, by least squares over sizes from a tenth of the largest on",
];

/// Measures and prints; `seconds` is the length of each part.
pub(crate) fn run(seconds: f64, json: bool) -> Result<(), FleetError> {
    let mut report = Report::new("fleet", false, &NOTES.map(str::to_owned));
    // First: memory freed by another part would be used again and not be counted.
    memory::run(&mut report)?;
    report.rows.extend(lockstep::cells(seconds)?);
    report.rows.extend(lockstep::episodes(seconds)?);
    start::run(&mut report, seconds)?;
    cost::run(&mut report, seconds)?;
    // Last, as it loads the machine until loops are late.
    real_time::run(&mut report, seconds)?;
    report
        .write(&mut std::io::stdout().lock(), json)
        .map_err(FleetError::Output)
}

/// A count with its noun.
fn count(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

/// Path of the launcher, beside this program.
fn program() -> Result<PathBuf, FleetError> {
    let own = std::env::current_exe().map_err(FleetError::Own)?;
    Ok(own.with_file_name("robocell"))
}
