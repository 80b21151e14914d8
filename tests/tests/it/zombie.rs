//! A process that was stopped, replaced by hand, and continues: nothing it says counts.

use std::process::{Child, Command, Stdio};

use cell_bus::{Bus, TopicMessage};
use cell_rt::process::{SIGCONT, SIGSTOP, kill};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmCommand, ArmStatus, Health, WorldState};
use robocell_tests::cell::{TestCell, pid};
use robocell_tests::program::wait_for;

/// The command of the process `zombie` again, for the next generation. The run file is its
/// standard input.
fn successor(zombie: u32) -> Child {
    let line = std::fs::read(format!("/proc/{zombie}/cmdline")).unwrap();
    let words: Vec<&str> = line
        .split(|byte| *byte == 0)
        .map(|word| std::str::from_utf8(word).unwrap())
        .filter(|word| !word.is_empty())
        .map(|word| if word == "1" { "2" } else { word })
        .collect();
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).stdout(Stdio::null());
    let run_file = std::fs::File::open(format!("/proc/{zombie}/fd/0")).unwrap();
    command.stdin(run_file);
    command.stderr(Stdio::null()).spawn().unwrap()
}

/// Messages of older generations that `reader` did not take.
fn fenced(bus: &Bus, reader: Process) -> u64 {
    let mut health = bus.latest::<Health>(TopicId::Health(reader)).unwrap();
    wait_for("its health", || {
        health.refresh().then(|| health.get().unwrap().fenced)
    })
}

/// Stops `name`, starts a successor by hand, lets the first continue. `used` tells the
/// generation of `name` whose messages `reader` uses, as `reader` itself says.
fn fences(name: &str, reader: Process, mut used: impl FnMut(&Bus) -> Option<u32>) {
    let cell = TestCell::start(&["franka-stack", "--headless", "--no-watchdog"]);
    let status = cell.wait_up();
    let zombie = pid(&status, name);
    let bus = cell.join();
    wait_for("the first", || (used(&bus)? == 1).then_some(()));
    kill(zombie, SIGSTOP).unwrap();
    let mut second = successor(zombie);
    wait_for("the second", || (used(&bus)? == 2).then_some(()));
    let before = fenced(&bus, reader);
    kill(zombie, SIGCONT).unwrap();
    wait_for("fenced messages", || {
        assert_eq!(used(&bus), Some(2), "{name}");
        (fenced(&bus, reader) > before + 3).then_some(())
    });
    second.kill().unwrap();
    second.wait().unwrap();
}

/// The newest message of `topic`.
fn newest<T: TopicMessage + Copy>(bus: &Bus, topic: TopicId) -> Option<T> {
    let mut latest = bus.latest::<T>(topic).unwrap();
    wait_for("a message", || latest.refresh().then_some(()));
    latest.get().copied()
}

#[test]
fn decisions_of_a_task_that_was_replaced_are_fenced() {
    fences("task", Process::Controller(0), |bus| {
        let status: ArmStatus = newest(bus, TopicId::ArmStatus(0))?;
        Some(status.goal_generation)
    });
}

#[test]
fn commands_of_a_controller_that_was_replaced_are_fenced() {
    fences("controller-0", Process::Physics, |bus| {
        let state: WorldState = newest(bus, TopicId::WorldState)?;
        Some(state.arms()[0].command_generation)
    });
}

#[test]
fn states_of_a_physics_that_was_replaced_are_fenced() {
    fences("physics", Process::Controller(0), |bus| {
        let command: ArmCommand = newest(bus, TopicId::ArmCommand(0))?;
        (1..=2).find(|generation| command.header.answers(*generation))
    });
}
