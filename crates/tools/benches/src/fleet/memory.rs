//! Memory of a cell: in one process, and of its processes.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use cell_rt::monotonic_ns;
use cell_rt::process::{SIGTERM, kill};
use serde_json::Value;

use super::{DEMO, lockstep, program};
use crate::error::FleetError;
use crate::procfs;
use crate::report::{Report, Row};

/// Number of cells at the first and at the second measurement. Reading the files of the first
/// cells leaves free memory, which the next ones use.
const FIRST: usize = 8;
const CELLS: usize = 40;
/// Ticks until a cell has all the memory that it works with.
const TICKS: usize = 200;
/// A cell of processes is up within this time, or the bench gives up.
const PATIENCE_NS: u64 = 60_000_000_000;
/// Interval of the checks.
const POLL: Duration = Duration::from_millis(200);
/// Running time of a cell of processes before its memory is read.
const RUN: Duration = Duration::from_secs(2);

/// Adds the rows. The first part of the bench: memory freed by another one would be used again.
pub(super) fn run(report: &mut Report) -> Result<(), FleetError> {
    let mut cells = Vec::new();
    let (mut one, mut first) = (None, None);
    for count in 1..=CELLS {
        let mut sim = lockstep::cell()?;
        // Run, not only made: memory is used when it is first written.
        for _ in 0..TICKS {
            sim.tick()?;
        }
        cells.push(sim);
        match count {
            1 => one = procfs::own_resident(),
            FIRST => first = procfs::own_resident(),
            _ => {}
        }
    }
    if let Some(one) = one {
        let row = Row::single("memory of a process with one cell", mib(one), "MiB");
        report.rows.push(row);
    }
    if let Some((first, all)) = first.zip(procfs::own_resident()) {
        let each = mib(all.saturating_sub(first)) / (CELLS - FIRST) as f64;
        let row = Row::single("memory of each further cell in it", each, "MiB");
        let n = CELLS - FIRST;
        report.rows.push(Row { n, ..row });
    }
    drop(cells);
    let parts = of_processes()?;
    let sum = parts.iter().map(|(_, bytes)| mib(*bytes)).sum();
    report
        .rows
        .push(Row::single("memory of a cell of processes", sum, "MiB"));
    let part = |(name, bytes): &(String, u64)| format!("{name} {:.1}", mib(*bytes));
    let parts: Vec<String> = parts.iter().map(part).collect();
    report.notes.push(format!(
        "memory of the processes (MiB): {}",
        parts.join(", ")
    ));
    Ok(())
}

fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// Each process of a cell that runs, with its launcher.
fn of_processes() -> Result<Vec<(String, u64)>, FleetError> {
    let path = program()?;
    let name = format!("bench-{}-memory", std::process::id());
    // The command of a user, so that the sum has every process that a run has.
    let mut command = Command::new(&path);
    command.args(["run", DEMO, "--headless", "--cell", &name]);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let started = command.spawn();
    let mut launcher = started.map_err(|source| FleetError::Program {
        path: path.clone(),
        source,
    })?;
    let measured = measure(&path, &name, &mut launcher);
    // It ends its processes and deletes its files.
    // SIGTERM, as SIGKILL would leave files of the cell.
    kill(launcher.id(), SIGTERM).ok();
    launcher.wait().ok();
    measured
}

fn measure(
    path: &Path,
    name: &str,
    launcher: &mut Child,
) -> Result<Vec<(String, u64)>, FleetError> {
    let until_ns = monotonic_ns() + PATIENCE_NS;
    while monotonic_ns() < until_ns && matches!(launcher.try_wait(), Ok(None)) {
        std::thread::sleep(POLL);
        let Some(processes) = processes(path, name) else {
            continue;
        };
        std::thread::sleep(RUN);
        let own = [("launcher".to_owned(), launcher.id())];
        let all = own.into_iter().chain(processes);
        let memory = all.filter_map(|(name, pid)| Some((name, procfs::memory(pid)?)));
        return Ok(memory.collect());
    }
    Err(FleetError::NotUp(name.to_owned()))
}

/// Name and id of each process of the cell; `None` until all are there.
fn processes(path: &Path, name: &str) -> Option<Vec<(String, u32)>> {
    let mut command = Command::new(path);
    command.args(["status", "--cell", name, "--json"]);
    let said = command.stdin(Stdio::null()).output().ok()?;
    let status: Value = serde_json::from_slice(&said.stdout).ok()?;
    let processes = status["processes"].as_array()?.iter();
    processes
        .map(|process| {
            let pid = u32::try_from(process["pid"].as_u64()?).ok()?;
            Some((process["name"].as_str()?.to_owned(), pid))
        })
        .collect()
}
