//! `robocell doctor`: what this machine lacks, and the fix for each.

use std::path::Path;

use cell_rt::memory::{free_bytes, is_tmpfs};
use cell_rt::priority::{PHYSICS_PRIORITY, probe_fifo};
use serde::Serialize;

use super::measure::{Measured, measure};
use crate::cli::{DoctorArgs, ReportArgs};
use crate::failure::{Code, Failure};
use crate::leftovers::Leftovers;
use crate::programs::beside;
use crate::rundir::{RunDir, base};
use crate::say;

/// Where shared memory lives.
const SHM: &str = "/dev/shm";

/// How long `--measure` takes (s).
const SECONDS: u64 = 10;

/// How a check went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Severity {
    Ok,
    /// Works, but worse.
    Warn,
    /// Does not work.
    Fail,
}

#[derive(Debug, Serialize)]
struct Check {
    name: &'static str,
    verdict: Severity,
    found: String,
    fix: Option<String>,
}

impl Check {
    fn new(
        name: &'static str,
        fine: bool,
        otherwise: Severity,
        found: impl Into<String>,
        fix: &str,
    ) -> Self {
        let verdict = if fine { Severity::Ok } else { otherwise };
        Self {
            name,
            verdict,
            found: found.into(),
            fix: (!fine).then(|| fix.to_owned()),
        }
    }
}

/// With `--measure --json`.
#[derive(Serialize)]
struct Report<'a> {
    checks: &'a [Check],
    measured: &'a Measured,
}

/// Checks this machine. Exit code 3 where a cell could not run at all.
pub(crate) fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let checks = [
        programs(),
        real_time(),
        locked_memory(),
        cores(),
        shared_memory(),
        run_directory(),
        leftovers(&args.report),
    ];
    let measured = args.measure.then(|| measure(SECONDS)).transpose()?;
    if args.report.json {
        let text = match &measured {
            None => serde_json::to_string(&checks),
            Some(measured) => serde_json::to_string(&Report {
                checks: &checks,
                measured,
            }),
        };
        say::line(text.map_err(Failure::configuration)?);
    } else {
        checks.iter().for_each(print);
        measured.iter().for_each(say::line);
    }
    if measured.is_some_and(|measured| measured.verdict == "unfit") {
        return Err(Failure::silent(Code::Configuration));
    }
    if checks.iter().any(|check| check.verdict == Severity::Fail) {
        return Err(Failure::silent(Code::Configuration));
    }
    Ok(())
}

fn print(check: &Check) {
    let mark = match check.verdict {
        Severity::Ok => "ok  ",
        Severity::Warn => "warn",
        Severity::Fail => "FAIL",
    };
    say::line(format_args!("{mark}  {:<20} {}", check.name, check.found));
    if let Some(fix) = &check.fix {
        say::line(format_args!("      {:<20} fix: {fix}", ""));
    }
}

fn programs() -> Check {
    let all = [
        "physics-proc",
        "controller-proc",
        "task-proc",
        "monitor-proc",
    ];
    let missing: Vec<_> = all
        .into_iter()
        .filter(|program| beside(program).is_err())
        .collect();
    let found = if missing.is_empty() {
        "all beside robocell".to_owned()
    } else {
        format!("missing beside robocell: {}", missing.join(", "))
    };
    Check::new(
        "programs",
        missing.is_empty(),
        Severity::Fail,
        found,
        "cargo build --release --workspace --bins",
    )
}

fn real_time() -> Check {
    let granted = probe_fifo(PHYSICS_PRIORITY);
    let found = if granted {
        "SCHED_FIFO is granted; a decision may be 30 ms old"
    } else {
        "SCHED_FIFO is refused: cycles come late on a busy machine; a decision may be 100 ms old"
    };
    let fix = "add `@YOUR_GROUP - rtprio 90` to /etc/security/limits.conf and log in again \
               (in a container: --cap-add SYS_NICE --ulimit rtprio=90)";
    Check::new("real-time priority", granted, Severity::Warn, found, fix)
}

/// The soft limit on locked memory in bytes; `None`: no limit.
fn locked_limit() -> Option<u64> {
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let line = limits
        .lines()
        .find(|line| line.starts_with("Max locked memory"))?;
    line.split_whitespace().nth(3)?.parse().ok()
}

fn locked_memory() -> Check {
    let limit = locked_limit();
    let fine = limit.is_none_or(|bytes| bytes >= 1 << 30) || cell_rt::process::user_id() == 0;
    let found = limit.map_or_else(
        || "no limit".to_owned(),
        |bytes| format!("limit {} MiB", bytes >> 20),
    );
    let fix = "add `@YOUR_GROUP - memlock unlimited` to /etc/security/limits.conf and log in again \
               (in a container: --ulimit memlock=-1)";
    Check::new("locked memory", fine, Severity::Warn, found, fix)
}

fn cores() -> Check {
    let count = cell_rt::priority::core_count();
    let fix = "physics and controller want a core each: give this machine or container two";
    Check::new("cores", count >= 2, Severity::Warn, format!("{count}"), fix)
}

fn shared_memory() -> Check {
    let needed = cell_bus::needed_bytes(1);
    let free = free_bytes(Path::new(SHM)).unwrap_or(0);
    let found = format!(
        "{} MiB free in {}, a cell needs {} MiB",
        free >> 20,
        SHM,
        needed >> 20
    );
    let fix = "free some (`ls -l /dev/shm`) or make it larger: mount -o remount,size=256M /dev/shm \
               (in a container: --shm-size=256m)";
    Check::new("shared memory", free >= needed, Severity::Fail, found, fix)
}

fn run_directory() -> Check {
    let base = base();
    let existing = base.ancestors().find(|dir| dir.exists());
    let fast = existing.is_some_and(|dir| is_tmpfs(dir).unwrap_or(false));
    let found = format!(
        "{} ({})",
        base.display(),
        if fast { "in memory" } else { "on a disk" }
    );
    Check::new(
        "run directory",
        fast,
        Severity::Warn,
        found,
        "processes start ten times slower on a disk: set ROBOCELL_RUN_DIR to a directory in /dev/shm",
    )
}

fn leftovers(args: &ReportArgs) -> Check {
    let mut found = Vec::new();
    for (name, dir) in RunDir::all() {
        let left = Leftovers::find(&dir);
        if dir.holder().is_none() && !left.is_empty() {
            found.push(format!("cell {name}: {left}"));
        }
    }
    let fine = found.is_empty();
    let text = if fine {
        "none".to_owned()
    } else {
        found.join("; ")
    };
    let cell = &args.cell.cell;
    let fix =
        format!("the next `robocell run DEMO --cell NAME` removes those of NAME (now `{cell}`)");
    Check::new("leftovers", fine, Severity::Warn, text, &fix)
}
