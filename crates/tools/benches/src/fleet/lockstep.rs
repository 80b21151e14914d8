//! Cells in one process at full speed: the number that a core carries.

use std::iter;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cell_model::Data;
use cell_model::cells::sweep::Case;
use cell_sim::episodes::Episodes;
use cell_sim::eval::template;
use cell_sim::{OneProcess, Program};
use ipc_types::TICK_NS;

use super::{DEMO, count};
use crate::error::FleetError;
use crate::procfs;
use crate::report::Row;

/// Turns through all numbers of jobs.
const TURNS: usize = 4;
/// Ticks between two looks at the clock.
const LOOK_TICKS: usize = 100;
/// Demo of the episodes: one cube to its mark.
const EPISODE: &str = "cube";

/// Work of a thread.
struct Work {
    simulated: Duration,
    wall: Duration,
    /// Time on a processor; `None` if the kernel does not count it.
    processor: Option<Duration>,
}

/// Numbers of jobs: powers of two, and all cores.
fn jobs() -> Vec<usize> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let next = |jobs: &usize| Some(2 * jobs).filter(|next| *next < cores);
    let mut all: Vec<usize> = iter::successors(Some(1), next).collect();
    if cores > 1 {
        all.push(cores);
    }
    all
}

/// Cells per core, and of all cores.
pub(super) fn cells(seconds: f64) -> Result<Vec<Row>, FleetError> {
    let jobs = jobs();
    let mut figures = vec![(Vec::new(), Vec::new()); jobs.len()];
    for _ in 0..TURNS {
        for (jobs, (per_core, in_all)) in jobs.iter().zip(&mut figures) {
            let works = turn(*jobs, seconds / TURNS as f64)?;
            for work in &works {
                // Per core by processor time, as another program may use the core as well.
                let cost = work.processor.unwrap_or(work.wall);
                per_core.push(work.simulated.div_duration_f64(cost));
            }
            let speed = |work: &Work| work.simulated.div_duration_f64(work.wall);
            in_all.push(works.iter().map(speed).sum());
        }
    }
    let name = |jobs, what| format!("lockstep, {}: {what}", count(jobs, "job"));
    let rows = jobs.iter().zip(figures).flat_map(|(jobs, (core, all))| {
        [
            Row::of(name(*jobs, "per core"), core, "cells"),
            Row::of(name(*jobs, "in all"), all, "cells"),
        ]
    });
    Ok(rows.collect())
}

fn turn(jobs: usize, seconds: f64) -> Result<Vec<Work>, FleetError> {
    let cells: Vec<OneProcess> = (0..jobs).map(|_| cell()).collect::<Result<_, _>>()?;
    // Cells are set up before the clock starts, one per thread, without anything shared.
    let results: Vec<Option<Result<Work, FleetError>>> = thread::scope(|scope| {
        let start = |sim| scope.spawn(move || work(sim, Duration::from_secs_f64(seconds)));
        let threads: Vec<_> = cells.into_iter().map(start).collect();
        threads.into_iter().map(|one| one.join().ok()).collect()
    });
    let panicked = || Err(FleetError::Panicked);
    let results = results.into_iter();
    results.map(|one| one.unwrap_or_else(panicked)).collect()
}

fn work(mut sim: OneProcess, budget: Duration) -> Result<Work, FleetError> {
    let (began, before_ns) = (Instant::now(), procfs::own_thread_ns());
    let mut ticks = 0;
    while began.elapsed() < budget {
        for _ in 0..LOOK_TICKS {
            if sim.tick()? {
                ticks += 1;
            } else {
                // A finished job is followed by a new cell, so that the thread never idles.
                sim = cell()?;
            }
        }
    }
    let used_ns = procfs::own_thread_ns().zip(before_ns);
    Ok(Work {
        simulated: Duration::from_nanos(ticks * TICK_NS),
        wall: began.elapsed(),
        processor: used_ns.map(|(after, before)| Duration::from_nanos(after - before)),
    })
}

/// A cell at its start.
pub(super) fn cell() -> Result<OneProcess, FleetError> {
    let mut spec = template(DEMO, "");
    let cell = spec.load_cell_from(&Data::checkout())?;
    spec.policy.clone_from(&cell.default_policy);
    Ok(OneProcess::new(&demos::policies(), &spec, cell)?)
}

/// Whole episodes per second.
pub(super) fn episodes(seconds: f64) -> Result<Vec<Row>, FleetError> {
    let program = Program {
        policies: demos::policies(),
        controllers: cell_sim::controller_proc::Controllers::default(),
        gateways: Vec::new(),
        data: Data::checkout(),
    };
    let mut spec = template(EPISODE, "");
    spec.policy = spec.load_cell_from(&program.data)?.default_policy;
    let jobs = jobs();
    let mut rates = vec![Vec::new(); jobs.len()];
    for turn in 0..TURNS {
        for (jobs, rates) in jobs.iter().zip(&mut rates) {
            let first = 1 + 1000 * turn as u64;
            let episodes = Episodes {
                program: &program,
                spec: &spec,
                record: None,
                jobs: *jobs,
                stop: &|| false,
            };
            rates.push(rate(&episodes, first, seconds / TURNS as f64)?);
        }
    }
    let name = |jobs: &usize| format!("episodes of {EPISODE}, {}", count(*jobs, "job"));
    let rows = jobs.iter().zip(rates);
    let rows = rows.map(|(jobs, rates)| Row::of(name(jobs), rates, "episodes/s"));
    Ok(rows.collect())
}

/// Episodes of all threads per second, at least one per thread. Those that end after `seconds`
/// count as well: without them long ones would be left out.
fn rate(episodes: &Episodes<'_>, first: u64, seconds: f64) -> Result<f64, FleetError> {
    let ended = Mutex::new((0.0, 0.0, None));
    let (began, budget) = (Instant::now(), Duration::from_secs_f64(seconds));
    let seeds = (first..).take_while(|seed| {
        let is_first = seed.saturating_sub(first) < episodes.jobs as u64;
        is_first || began.elapsed() < budget
    });
    let cases = seeds.map(|seed| Case {
        seed,
        ..Case::default()
    });
    episodes.run(cases, &|one| {
        let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
        ended.0 += 1.0;
        ended.1 += one.wall_time.as_secs_f64();
        // The first failure ends the bench: a rate of failing episodes is not a rate.
        if let Err(reason) = one.result {
            ended.2 = Some(reason);
        }
        true
    });
    match ended.into_inner().unwrap_or_else(PoisonError::into_inner) {
        (_, _, Some(reason)) => Err(FleetError::Episode(reason)),
        (ended, thread_s, None) => Ok(episodes.jobs as f64 * ended / thread_s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_1_to_all_cores_once_each() {
        let (jobs, cores) = (jobs(), thread::available_parallelism().unwrap().get());
        assert_eq!((jobs[0], *jobs.last().unwrap()), (1, cores));
        assert!(jobs.is_sorted_by(|a, b| a < b), "{jobs:?}");
    }

    #[test]
    fn cells_advance_in_each_job() {
        for work in turn(2, 0.05).unwrap() {
            assert!(work.simulated > Duration::ZERO && work.wall >= work.simulated / 1000);
        }
    }
}
