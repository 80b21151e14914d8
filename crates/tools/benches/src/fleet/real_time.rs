//! Cells of processes in real time, one more at a time, until their loops are late.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

use cell_rt::monotonic_ns;
use ipc_types::health::Scheduling;
use ipc_types::topic::Process;
use supervisor::failure::Failure;
use supervisor::run::{End, LiveCell};

use super::count;
use crate::e2e::{Series, WARM_UP_NS, WINDOW_NS, lateness, nanos, plan};
use crate::error::FleetError;
use crate::report::{Report, Row};

/// The series ends when the lateness p99 is this many times that of one cell.
const LATE: f64 = 2.0;
/// Lateness below it is noise of the clock and the scheduler (us): a twentieth of a tick.
const LEAST_US: f64 = 50.0;
/// Largest number of cells per core.
const CELLS_PER_CORE: usize = 4;

/// Lateness of the cells of one step, of all their seconds.
#[derive(Default)]
struct Late {
    controller: Series,
    physics: Series,
    fifo: bool,
}

/// State shared by the cells of a step.
struct Step {
    cells: usize,
    ready: AtomicUsize,
    failed: AtomicBool,
}

/// Adds the rows.
pub(super) fn run(report: &mut Report, seconds: f64) -> Result<(), FleetError> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let most = CELLS_PER_CORE * cores;
    let (mut carried, mut one_us) = (0, None);
    // One more at a time: the number sought is the last one whose loops are in time.
    for cells in 1..=most {
        let late = match step(cells, seconds) {
            Ok(late) => late,
            // One cell has to run; with more of them the machine may be full.
            Err(failure) if cells == 1 => return Err(failure.into()),
            Err(failure) => {
                let note = format!("real time, {}: {failure}", count(cells, "cell"));
                report.notes.push(note);
                break;
            }
        };
        if late.fifo {
            report.scheduling = "fifo";
        }
        // Below 50 us a ratio would compare noise with noise.
        let p99_us = add(report, cells, &late).max(LEAST_US);
        if p99_us >= LATE * *one_us.get_or_insert(p99_us) {
            break;
        }
        carried = cells;
    }
    let row = Row::single(
        "real time: cells until p99 doubles",
        carried as f64,
        "cells",
    );
    report.rows.push(row);
    if carried == most {
        let note = format!("real time: more than {most} cells are not tried");
        report.notes.push(note);
    }
    Ok(())
}

/// Adds the rows of one step; returns the median lateness p99 of the later loop (us).
fn add(report: &mut Report, cells: usize, late: &Late) -> f64 {
    let loops = [("controller", &late.controller), ("physics", &late.physics)];
    let p99s = loops.map(|(loop_, series)| {
        let name = format!("real time, {}: {loop_} lateness", count(cells, "cell"));
        let row = series.row(name);
        let p99_us = row.p99;
        report.rows.push(row);
        p99_us
    });
    p99s.into_iter().fold(0.0, f64::max)
}

/// Runs so many cells at once.
fn step(cells: usize, seconds: f64) -> Result<Late, Failure> {
    let step = Step {
        cells,
        ready: AtomicUsize::new(0),
        failed: AtomicBool::new(false),
    };
    let results: Vec<_> = thread::scope(|scope| {
        let start = |index| {
            let step = &step;
            scope.spawn(move || {
                let one = cell(index, seconds, step);
                step.failed.fetch_or(one.is_err(), Ordering::Relaxed);
                one
            })
        };
        let threads: Vec<_> = (0..cells).map(start).collect();
        threads.into_iter().map(|one| one.join().ok()).collect()
    });
    let mut all = Late::default();
    for one in results {
        let one = one.unwrap_or_else(|| Err(Failure::gave_up("a thread of the bench panicked")))?;
        all.controller.0.extend(one.controller.0);
        all.physics.0.extend(one.physics.0);
        all.fifo |= one.fifo;
    }
    Ok(all)
}

/// Runs one of them, from its start to its end. Its processes end with this thread.
fn cell(index: usize, seconds: f64, step: &Step) -> Result<Late, Failure> {
    let name = format!("bench-{}-{index}", std::process::id());
    let live = LiveCell::start(plan(&name)?)?;
    let mut late = Late::default();
    let (mut is_ready, mut next_ns, mut end_ns) = (false, 0, None);
    let end = live.stay(|live| {
        if !is_ready && live.is_ready() {
            is_ready = true;
            step.ready.fetch_add(1, Ordering::Relaxed);
        }
        // One failed cell ends the step: the others would run with less load than named.
        if step.failed.load(Ordering::Relaxed) {
            live.stop();
        }
        // All cells are up before any is measured, as a start loads the machine.
        if step.ready.load(Ordering::Relaxed) < step.cells {
            return;
        }
        let now = monotonic_ns();
        let end_ns = *end_ns.get_or_insert_with(|| {
            next_ns = now + WARM_UP_NS;
            next_ns + nanos(seconds).max(WINDOW_NS)
        });
        if now >= next_ns {
            next_ns = now + WINDOW_NS;
            late.sample(live);
        }
        if now >= end_ns {
            live.stop();
        }
    });
    match end {
        End::GaveUp(failure) => Err(failure),
        _ => Ok(late),
    }
}

impl Late {
    fn sample(&mut self, live: &LiveCell) {
        let watch = live.watch();
        let controller = watch.health(Process::Controller(0));
        let Some((physics, controller)) = watch.health(Process::Physics).zip(controller) else {
            return;
        };
        self.fifo = physics.scheduling == Scheduling::Fifo.code();
        self.controller.0.push(lateness(controller));
        self.physics.0.push(lateness(physics));
    }
}
