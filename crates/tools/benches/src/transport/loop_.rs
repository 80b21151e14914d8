//! `bench loop`: lateness of the start of a 1 kHz cycle, and of physics that saves a state of 1
//! MB.

use std::process::Command;

use cell_rt::priority::{self, PHYSICS_PRIORITY};
use cell_rt::{Grid, monotonic_ns, sleep_until};

use super::site::BenchRun;
use super::{BenchError, io};
use crate::kept::KeptPhysics;
use crate::report::{Report, Samples};
use crate::versions;

const PERIOD_NS: u64 = 1_000_000;
/// Cycles of a row in one turn, one second: rows take turns.
const BLOCK: usize = 1000;
/// Turns of each row.
const ROUNDS: usize = 12;

/// Another program that measures this, and its row.
const CYCLICTEST: &str = "cyclictest";
/// The rows of physics.
const NOT_KEPT: &str = "physics, no state is kept";
const KEPT: &str = "physics, a state of 1 MB is kept";
const KEEPING: &str = "time of a tick that is spent on keeping";

/// Measures and prints.
pub(crate) fn run(json: bool) -> Result<(), BenchError> {
    let place = BenchRun::create()?;
    // Its writing thread gets neither real-time priority nor the core.
    let mut physics = KeptPhysics::new(&place.dir)?;
    // The last core: interrupts are mostly on the first.
    let core = priority::core_count() - 1;
    let granted = priority::request(PHYSICS_PRIORITY, Some(core));
    let mut grid = Samples::with_capacity(ROUNDS * BLOCK);
    let mut sleep = Samples::with_capacity(ROUNDS * BLOCK);
    let [mut not_kept, mut kept, mut keeping] =
        [(); 3].map(|()| Samples::with_capacity(ROUNDS * BLOCK));
    let mut cyclictest = Some(Samples::with_capacity(ROUNDS * BLOCK));
    for _ in 0..ROUNDS {
        grid_block(&mut grid, granted.fifo);
        sleep_block(&mut sleep);
        physics.not_kept(&mut new_grid(granted.fifo), BLOCK, &mut not_kept);
        let both = (&mut kept, &mut keeping);
        physics.kept(&mut new_grid(granted.fifo), BLOCK, both);
        // Once missing, it is not tried again.
        cyclictest = match cyclictest {
            Some(samples) => cyclictest_block(samples, core, granted.fifo)?,
            None => None,
        };
    }
    priority::set_other().map_err(io("leave real-time scheduling"))?;
    let mut report = Report::new("loop", granted.fifo, &granted.refused);
    report.notes.push(format!(
        "lateness of the start of a cycle of 1 ms on core {core}, rows in turns of one second"
    ));
    report.draw("lateness of the grid", &grid);
    report.draw("lateness of nanosleep", &sleep);
    report.rows = vec![
        grid.into_row("grid".to_owned()),
        sleep.into_row("nanosleep".to_owned()),
    ];
    let megabytes = physics.megabytes();
    report.notes.push(format!(
        "physics: a tick of a scene at rest, without a bus; its state has {megabytes:.2} MB"
    ));
    report.rows.push(not_kept.into_row(NOT_KEPT.to_owned()));
    report.rows.push(kept.into_row(KEPT.to_owned()));
    report.rows.push(keeping.into_row(KEEPING.to_owned()));
    report.compare(KEPT, NOT_KEPT);
    let base = add_cyclictest(&mut report, cyclictest);
    report.compare("grid", base);
    // Compared with itself it would be 1.
    if base != "nanosleep" {
        report.compare("nanosleep", base);
    }
    report
        .write(&mut std::io::stdout().lock(), json)
        .map_err(io("print"))
}

/// Adds the row of cyclictest, if installed; returns the row to compare with.
fn add_cyclictest(report: &mut Report, samples: Option<Samples>) -> &'static str {
    if let Some(samples) = samples {
        report.rows.push(samples.into_row(CYCLICTEST.to_owned()));
        let version = versions::of_program(CYCLICTEST);
        report
            .notes
            .extend(version.map(|version| format!("compared with {version}")));
        return CYCLICTEST;
    }
    let note = "cyclictest is not installed; compared with a plain sleep";
    report.notes.push(note.to_owned());
    "nanosleep"
}

fn new_grid(fifo: bool) -> Grid {
    Grid::new(PERIOD_NS, monotonic_ns(), fifo)
}

/// The cell's loop: sleeps most of the way, spins the rest.
fn grid_block(samples: &mut Samples, fifo: bool) {
    let mut grid = new_grid(fifo);
    for _ in 0..BLOCK {
        samples.record(grid.wait().lateness_ns());
    }
}

/// The method of cyclictest: an absolute sleep, nothing else.
fn sleep_block(samples: &mut Samples) {
    let mut deadline_ns = monotonic_ns() + PERIOD_NS;
    for _ in 0..BLOCK {
        sleep_until(deadline_ns);
        samples.record(monotonic_ns().saturating_sub(deadline_ns));
        deadline_ns += PERIOD_NS;
    }
}

/// One turn of cyclictest at the same priority on the same core; `None` if it is not installed.
fn cyclictest_block(
    mut samples: Samples,
    core: usize,
    fifo: bool,
) -> Result<Option<Samples>, BenchError> {
    let mut command = Command::new(CYCLICTEST);
    command.args([
        "--quiet",
        "--mlockall",
        "--nsecs",
        "--threads=1",
        "--interval=1000",
    ]);
    command
        .arg(format!("--affinity={core}"))
        .arg(format!("--loops={BLOCK}"))
        .arg("--verbose");
    if fifo {
        command.args(["--policy=fifo", &format!("--priority={PHYSICS_PRIORITY}")]);
    }
    let output = match command.output() {
        Ok(output) => output,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(io("start cyclictest")(error)),
    };
    let before = samples.count();
    for latency_ns in latencies(&String::from_utf8_lossy(&output.stdout)) {
        samples.record(latency_ns);
    }
    // Another version with another output: no figures instead of wrong ones.
    if samples.count() == before {
        return Err(BenchError::Foreign(CYCLICTEST));
    }
    Ok(Some(samples))
}

/// Reads lines of `THREAD: CYCLE: LATENCY`.
fn latencies(text: &str) -> impl Iterator<Item = u64> {
    text.lines().filter_map(|line| {
        let mut fields = line.split(':').map(str::trim);
        fields.next()?.parse::<u32>().ok()?;
        fields.next()?.parse::<u64>().ok()?;
        fields.next()?.parse().ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_cyclictest_are_read() {
        let text = "Max CPUs = 2\n       0:       0:   12345\n       0:       1:    2345\n# end\n";
        assert_eq!(latencies(text).collect::<Vec<_>>(), [12345, 2345]);
    }
}
