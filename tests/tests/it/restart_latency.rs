//! How long the cell is without a task after kill -9.

use std::time::{Duration, Instant};

use cell_rt::process::{SIGKILL, kill};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, Health};
use robocell_tests::cell::TestCell;
use robocell_tests::program::wait_for;

/// Kills; far enough apart that the supervisor sees no crash loop.
const KILLS: usize = 4;

/// The time from kill -9 of the task to the first decision of the next one is
/// printed, not bounded: it is a figure of the machine.
#[test]
fn a_killed_task_decides_again() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_up();
    let bus = cell.join();
    let mut health = bus
        .latest::<Health>(TopicId::Health(Process::Task))
        .unwrap();
    let mut decision = bus.latest::<Decision>(TopicId::Decision).unwrap();
    let mut waits = Vec::new();
    for _ in 0..KILLS {
        let (pid, generation) = wait_for("a task that decides", || {
            health.refresh();
            decision.refresh();
            let (health, decision) = (health.get()?, decision.get()?);
            let same = health.header.generation == decision.header.generation;
            same.then_some((health.pid, health.header.generation))
        });
        kill(pid, SIGKILL).unwrap();
        let killed = Instant::now();
        wait_for("a decision of the next task", || {
            decision.refresh();
            (decision.get()?.header.generation > generation).then_some(())
        });
        waits.push(killed.elapsed());
        // A process that lives for less than this counts towards a crash loop.
        let ticks = decision.get().unwrap().header.tick + 2_600;
        wait_for("the cell to continue", || {
            decision.refresh();
            (decision.get()?.header.tick > ticks).then_some(())
        });
    }
    waits.sort();
    let ms = |wait: &Duration| wait.as_secs_f64() * 1.0e3;
    println!(
        "kill -9 to the next decision, ms: {:?}",
        waits.iter().map(ms).collect::<Vec<_>>()
    );
}
