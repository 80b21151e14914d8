//! Kills at random instants of a launcher's and a process's life. `ROBOCELL_SERIES=N` asks
//! for N kills; a few are made otherwise. Each series prints its figures.

use std::path::Path;
use std::time::{Duration, Instant};

use cell_rt::process::{SIGKILL, SIGSTOP, is_alive, kill};
use cell_run::children::ChildId;
use robocell_tests::assert::{prefix, segments};
use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::wait_for;
use robocell_tests::random;

/// A process is killed within so much time after its start.
const EARLY_S: f64 = 0.06;
/// Of one process in one cell: a sixth kill within 10 s would be a crash loop.
const KILLS: usize = 4;
const PROGRAMS: [&str; 4] = [
    "physics-proc",
    "controller-proc",
    "monitor-proc",
    "task-proc",
];

fn count(few: usize) -> usize {
    let asked = std::env::var("ROBOCELL_SERIES").ok();
    asked.and_then(|text| text.parse().ok()).unwrap_or(few)
}

fn start(base: tempfile::TempDir) -> TestCell {
    TestCell::start_in(base, &["franka-stack", "--headless"])
}

fn children(run_dir: &Path) -> Vec<u32> {
    let ids = ChildId::all(run_dir);
    ids.iter().map(|id| id.pid).collect()
}

/// The process of `program` that is not `before`.
fn next(run_dir: &Path, program: &str, before: Option<u32>) -> Option<u32> {
    let is_it = |pid: &u32| {
        let name = std::fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default();
        Some(*pid) != before && name.trim_end() == program
    };
    children(run_dir).into_iter().find(is_it)
}

fn pause(seconds: f64) {
    std::thread::sleep(Duration::from_secs_f64(seconds));
}

/// Median and greatest, in milliseconds.
fn figures(mut times: Vec<Duration>) -> String {
    times.sort_unstable();
    let ms = |time: Option<&Duration>| time.map_or(0.0, |time| time.as_secs_f64() * 1e3);
    format!(
        "p50 {:.0} ms, max {:.0} ms",
        ms(times.get(times.len() / 2)),
        ms(times.last())
    )
}

#[test]
fn of_launchers_killed_at_random_instants_end_their_processes_and_the_next_start_is_clean() {
    let (kills, mut seed) = (count(4), 3);
    let (mut dir, mut ends) = (base(), Vec::new());
    for number in 0..kills {
        let cell = start(dir);
        let run_dir = cell.run_dir();
        wait_for("a process", || {
            (!children(&run_dir).is_empty()).then_some(())
        });
        pause(1.5 * random(&mut seed));
        let pids = children(&run_dir);
        // Each fourth time one of them is stopped: it cannot hear that it should end.
        if number % 4 == 3
            && let Some(pid) = pids.get(number / 4 % pids.len().max(1))
        {
            kill(*pid, SIGSTOP).ok();
        }
        let began = Instant::now();
        dir = cell.crash();
        wait_for("the end of the processes", || {
            pids.iter().all(|pid| !is_alive(*pid)).then_some(())
        });
        ends.push(began.elapsed());
    }
    let mut cell = start(dir);
    cell.wait_up();
    // A process that died while it wrote is cleaned up after once more.
    let (of_this_run, family) = {
        let prefix = prefix(&cell.run_dir());
        (prefix.clone(), prefix[..8].to_owned())
    };
    wait_for("nothing of earlier runs", || {
        let all = segments(&family);
        all.iter()
            .all(|name| name.starts_with(&of_this_run))
            .then_some(())
    });
    assert_eq!(cell.ask(&["down"]).code, 0);
    assert_eq!(cell.wait_end().code, 0);
    assert!(segments(&family).is_empty());
    println!(
        "{kills} launchers killed; their processes ended after {}",
        figures(ends)
    );
}

#[test]
fn of_processes_killed_in_their_first_moments_end_no_cell() {
    let (kills, mut seed) = (count(16), 5);
    let (mut done, mut downs, mut starts) = (0, Vec::new(), Vec::new());
    let mut dir = base();
    while done < kills {
        let mut cell = start(dir);
        let run_dir = cell.run_dir();
        let mut killed = Instant::now();
        for program in PROGRAMS {
            let mut before = None;
            for _ in 0..KILLS.min(kills - done) {
                let pid = wait_for("a start", || next(&run_dir, program, before));
                pause(EARLY_S * random(&mut seed));
                kill(pid, SIGKILL).ok();
                before = Some(pid);
                killed = Instant::now();
                done += 1;
            }
        }
        cell.wait_up();
        starts.push(killed.elapsed());
        let asked = Instant::now();
        assert_eq!(cell.ask(&["down"]).code, 0);
        downs.push(asked.elapsed());
        let said = cell.wait_end();
        assert_eq!(said.code, 0, "{said:?}");
        assert!(!said.stderr.contains("no sign of life"), "{}", said.stderr);
        dir = base();
    }
    println!(
        "{done} processes killed within {} ms of their start; the last kill of a cell was answered with all up after {}; `down` \
         answered after {}",
        EARLY_S * 1e3,
        figures(starts),
        figures(downs)
    );
}
