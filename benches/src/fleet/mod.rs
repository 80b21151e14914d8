//! `robocell bench fleet`: what many cells cost, and how the cost of one grows.
//!
//! Memory of a cell; cells that a core carries in lockstep; episodes per second over
//! jobs; how long an episode takes to begin; the tick over the size of a cell, with the
//! exponent; last, cells of processes in real time, one more at a time.

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

/// What runs where nothing else is said.
const DEMO: &str = "franka-stack";

const NOTES: [&str; 5] = [
    "lockstep: simulated seconds in a second of processor time, of a cell of franka-stack",
    "start: the reset begins with the request and ends with the tick in which all have seen it",
    "tick over size: mean tick of ten, with one decision; an arm of reach holds",
    "real time: lateness p99 of the later loop, controller or physics; below 50 us it counts as 50 us",
    "exponent k: cost(n) - cost(0) = b n^k, by least squares over sizes from a tenth of the largest on",
];

/// Measures and prints; `seconds` is the length of each part.
pub(crate) fn run(seconds: f64, json: bool) -> Result<(), FleetError> {
    let mut report = Report::new("fleet", false, &NOTES.map(str::to_owned));
    memory::run(&mut report)?;
    report.rows.extend(lockstep::cells(seconds)?);
    report.rows.extend(lockstep::episodes(seconds)?);
    start::run(&mut report, seconds)?;
    cost::run(&mut report, seconds)?;
    real_time::run(&mut report, seconds)?;
    report
        .write(&mut std::io::stdout().lock(), json)
        .map_err(FleetError::Output)
}

/// So many of them, in words.
fn count(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

/// The launcher, which is beside this program.
fn program() -> Result<PathBuf, FleetError> {
    let own = std::env::current_exe().map_err(FleetError::Own)?;
    Ok(own.with_file_name("robocell"))
}
