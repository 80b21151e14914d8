//! Processes that die during a start or while they hold messages, and the files they leave.

use crate::common;

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use cell_bus::{Bus, RunSite, segments, wipe};
use common::{RUN, TestRun, decision};
use ipc_types::Decision;
use ipc_types::header::Message;
use ipc_types::topic::TopicId;

/// Not a test by itself: the process that is killed, with its generation.
#[test]
#[ignore = "run by other tests as a process of its own"]
fn helper_publishes_until_killed() {
    let Ok(spec) = std::env::var("CELL_BUS_HELPER") else {
        return;
    };
    let mut parts = spec.splitn(3, ' ');
    let generation = parts.next().unwrap().parse().unwrap();
    let prefix = parts.next().unwrap().to_owned();
    let site = RunSite {
        prefix,
        root: parts.next().unwrap().into(),
    };
    let bus = Bus::join(&site, RUN, generation, "helper").unwrap();
    let mut publisher = bus.publisher::<Decision>(TopicId::Decision).unwrap();
    for tick in 1.. {
        publisher.publish_copy(&decision(tick, generation)).unwrap();
        if tick == 1 {
            println!("\nready");
        }
        cell_rt::sleep_until(cell_rt::monotonic_ns() + 100_000);
    }
}

fn helper(site: &RunSite, generation: u32) -> Child {
    Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "faults::helper_publishes_until_killed",
            "--ignored",
            "--nocapture",
        ])
        .env(
            "CELL_BUS_HELPER",
            format!("{generation} {} {}", site.prefix, site.root.display()),
        )
        .stdout(Stdio::piped())
        .spawn()
        .unwrap()
}

fn wait_until_ready(child: &mut Child) {
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(
        lines.any(|line| line.unwrap() == "ready"),
        "the helper ended early"
    );
}

#[test]
fn a_reader_follows_a_writer_through_kills_and_restarts() {
    let run = TestRun::new();
    let mut subscriber = run
        .join(1)
        .subscriber::<Decision>(TopicId::Decision)
        .unwrap();
    for generation in 1..=12 {
        let mut child = helper(&run.site, generation);
        wait_until_ready(&mut child);
        let mut heard = 0;
        while heard < 5 {
            if let Some(message) = subscriber.take() {
                assert_eq!(message.drops, message.header().generation);
                heard += u32::from(message.header().generation == generation);
            }
        }
        child.kill().unwrap();
        // The last message stays readable while its writer is dead.
        assert_eq!(subscriber.current().unwrap().drops, generation);
        child.wait().unwrap();
    }
    assert_eq!(subscriber.counts().rejected, 0);
}

#[test]
fn kills_during_start_up_stop_nobody_from_starting() {
    let run = TestRun::new();
    for attempt in 0..40_u64 {
        let mut child = helper(&run.site, 1);
        // Spread over the start of the process, at any speed of the machine.
        cell_rt::sleep_until(cell_rt::monotonic_ns() + attempt * 250_000);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let mut subscriber = run
        .join(1)
        .subscriber::<Decision>(TopicId::Decision)
        .unwrap();
    let mut child = helper(&run.site, 2);
    wait_until_ready(&mut child);
    while subscriber.take().is_none() {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn the_wipe_leaves_nothing_and_takes_nothing_else() {
    let run = TestRun::new();
    let neighbour = TestRun::new();
    let mut child = helper(&run.site, 1);
    wait_until_ready(&mut child);
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = segments(&neighbour.site).unwrap();
    assert!(!segments(&run.site).unwrap().is_empty() && !kept.is_empty());
    wipe(&run.site).unwrap();
    assert!(segments(&run.site).unwrap().is_empty() && !run.site.root.exists());
    assert_eq!(segments(&neighbour.site).unwrap(), kept);
    wipe(&run.site).unwrap();
}

#[test]
fn a_full_cell_fits_into_what_is_reserved_for_it() {
    let run = TestRun::new();
    let bus = run.join(1);
    let _ports = (
        bus.publisher::<ipc_types::WorldState>(TopicId::WorldState)
            .unwrap(),
        bus.publisher::<Decision>(TopicId::Decision).unwrap(),
        bus.publisher::<ipc_types::TraceLine>(TopicId::Trace)
            .unwrap(),
        bus.publisher::<ipc_types::ArmCommand>(TopicId::ArmCommand(0))
            .unwrap(),
        bus.publisher::<ipc_types::ArmStatus>(TopicId::ArmStatus(0))
            .unwrap(),
        bus.operator_server().unwrap(),
        bus.operator_client().unwrap(),
    );
    let sizes = segments(&run.site).unwrap();
    let used: u64 = sizes
        .iter()
        .map(|path| path.metadata().unwrap().len())
        .sum();
    assert!(
        used <= cell_bus::needed_bytes(1),
        "{used} of {}",
        cell_bus::needed_bytes(1)
    );
    println!("{used} bytes used, {} reserved", cell_bus::needed_bytes(1));
}

#[test]
fn a_service_that_is_not_there_is_an_error_with_advice() {
    let run = TestRun::new();
    let bus = run.join(1);
    let error = bus
        .subscriber::<ipc_types::ArmCommand>(TopicId::ArmCommand(7))
        .unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains("arm/7/command") && text.contains("robocell status"),
        "{text}"
    );
}
