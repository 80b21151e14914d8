//! `robocell doctor`: what this machine lacks, what that costs, and the fix for each.

mod machine;

use std::path::Path;

use cell_rt::memory::{free_bytes, is_tmpfs};
use cell_rt::priority::{PHYSICS_PRIORITY, probe_fifo};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Code, Failure};
use supervisor::leftovers::Leftovers;
use supervisor::programs::beside;
use supervisor::rundir::{RunDir, checked_base};

use super::measure::{Measured, measure};
use crate::args::{DoctorArgs, ReportArgs};
use crate::{output, say};

/// Where shared memory lives.
const SHM: &str = "/dev/shm";

/// How long `--measure` takes (s).
const SECONDS: u64 = 10;

/// How a check went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Severity {
    Ok,
    /// Works, but worse.
    Warn,
    /// Does not work.
    Fail,
}

/// One thing that was looked at.
#[derive(Debug, Serialize, JsonSchema)]
struct Check {
    name: &'static str,
    verdict: Severity,
    found: String,
    /// What does not work, or works worse, until then; null where nothing is missing.
    cost: Option<String>,
    /// What to do; null where nothing is missing.
    fix: Option<String>,
}

impl Check {
    /// Something that is there.
    fn ok(name: &'static str, found: impl Into<String>) -> Self {
        Self {
            name,
            verdict: Severity::Ok,
            found: found.into(),
            cost: None,
            fix: None,
        }
    }

    /// [`Check::ok`] where it is `fine`; else what that costs, and what to do about it.
    fn new(
        name: &'static str,
        fine: bool,
        otherwise: Severity,
        found: impl Into<String>,
        (cost, fix): (&str, &str),
    ) -> Self {
        let check = Self::ok(name, found);
        if fine {
            return check;
        }
        Self {
            verdict: otherwise,
            cost: Some(cost.to_owned()),
            fix: Some(fix.to_owned()),
            ..check
        }
    }
}

/// The result of `robocell doctor --json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct DoctorReport<'a> {
    /// What was looked at.
    checks: &'a [Check],
    /// With `--measure`.
    measured: Option<&'a Measured>,
}

/// Checks this machine. Exit code 3 where a cell could not run at all.
pub(crate) fn doctor(args: &DoctorArgs) -> Result<(), Failure> {
    let checks = [
        programs(),
        machine::page(),
        real_time(),
        locked_memory(),
        cores(),
        machine::governor(),
        shared_memory(),
        run_directory(),
        leftovers(&args.report),
        machine::node(),
        machine::npm(),
    ];
    let measured = args.measure.then(|| measure(SECONDS)).transpose()?;
    if args.report.json {
        output::print(&DoctorReport {
            checks: &checks,
            measured: measured.as_ref(),
        })?;
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
    if let Some(cost) = &check.cost {
        say::line(format_args!("      {:<20} cost: {cost}", ""));
    }
    if let Some(fix) = &check.fix {
        say::line(format_args!("      {:<20} fix: {fix}", ""));
    }
}

fn programs() -> Check {
    let all = [
        "physics-proc",
        "controller-proc",
        "fci-proc",
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
        ("no cell runs", "cargo build --release --workspace --bins"),
    )
}

fn real_time() -> Check {
    let granted = probe_fifo(PHYSICS_PRIORITY);
    let found = if granted {
        "SCHED_FIFO is granted; a decision may be 30 ms old"
    } else {
        "SCHED_FIFO is refused"
    };
    let cost = "cycles of 1 ms are late while other programs work; a decision may be 100 ms old";
    let fix = "add `@YOUR_GROUP - rtprio 90` to /etc/security/limits.conf and log in again \
               (in a container: --cap-add SYS_NICE --ulimit rtprio=90)";
    Check::new(
        "real-time priority",
        granted,
        Severity::Warn,
        found,
        (cost, fix),
    )
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
    // The limit of `cell_rt::memory::lock_all`. Root may exceed the limit of its session.
    let fine = limit.is_none_or(|bytes| bytes >= 1 << 30) || cell_rt::process::user_id() == 0;
    let found = limit.map_or_else(
        || "no limit".to_owned(),
        |bytes| format!("limit {} MiB", bytes >> 20),
    );
    let fix = "add `@YOUR_GROUP - memlock unlimited` to /etc/security/limits.conf and log in again \
               (in a container: --ulimit memlock=-1)";
    let cost = "a page of memory that was swapped out delays a cycle by milliseconds";
    Check::new("locked memory", fine, Severity::Warn, found, (cost, fix))
}

fn cores() -> Check {
    let count = cell_rt::priority::core_count();
    let cost = "physics and controllers wait for each other: real time is missed (lockstep, \
                `--speed max`, is not affected)";
    let fix = "give this machine or container two cores; four leave room for the page";
    Check::new(
        "cores",
        count >= 2,
        Severity::Warn,
        format!("{count}"),
        (cost, fix),
    )
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
    Check::new(
        "shared memory",
        free >= needed,
        Severity::Fail,
        found,
        ("no cell starts", fix),
    )
}

fn run_directory() -> Check {
    let base = match checked_base() {
        Ok(base) => base,
        Err(failure) => {
            let (name, cost) = ("run directory", "no cell starts");
            let fix = "remove it, or set ROBOCELL_RUN_DIR to a directory of your own";
            return Check::new(name, false, Severity::Fail, failure.message, (cost, fix));
        }
    };
    // The directory itself is made by the first run.
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
        (
            "processes start ten times slower",
            "set ROBOCELL_RUN_DIR to a directory in /dev/shm",
        ),
    )
}

fn leftovers(args: &ReportArgs) -> Check {
    let mut found = Vec::new();
    // A directory that is refused is told by the check before this one.
    for (name, dir) in RunDir::all().unwrap_or_default() {
        let left = Leftovers::find(&dir);
        // The files of a cell that runs are in use.
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
    let cost = "memory and files of cells that were killed are in use";
    Check::new("leftovers", fine, Severity::Warn, text, (cost, &fix))
}
