//! A process of the same user that sends nonsense of the right type.

use std::time::Duration;

use cell_bus::{Bus, TopicMessage};
use ipc_types::arm::{StopAction, StopCause};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, Health, Pose, Wire, WorldState};
use robocell_tests::cell::{TestCell, generation};
use robocell_tests::program::wait_for;

const NAMES: [&str; 4] = ["physics", "controller-0", "task", "monitor"];

fn newest<T: TopicMessage + Copy>(bus: &Bus, topic: TopicId) -> T {
    let mut latest = bus.latest::<T>(topic).unwrap();
    wait_for("a message", || latest.refresh().then_some(()));
    *latest.get().unwrap()
}

/// Sends messages as the next start of their writer would, each made by `fill` for the
/// tick of now, until `seen`.
fn send<T: TopicMessage + Wire>(
    cell: &TestCell,
    topic: TopicId,
    mut fill: impl FnMut(&mut T),
    mut seen: impl FnMut(&Bus) -> bool,
) {
    let rogue = cell.join_as(2);
    let mut port = rogue.publisher::<T>(topic).unwrap();
    let bus = cell.join();
    wait_for("what it leads to", || {
        let tick = newest::<WorldState>(&bus, TopicId::WorldState).header.tick;
        port.publish(|message| {
            *message = T::zeroed();
            fill(message);
            *message.header_mut() = Header::caused_by::<T>(tick);
        })
        .unwrap();
        std::thread::sleep(Duration::from_millis(1));
        seen(&bus).then_some(())
    });
}

fn note(bus: &Bus, process: Process) -> (u64, String) {
    let health: Health = newest(bus, TopicId::Health(process));
    (health.rejected, health.note.as_str().to_owned())
}

#[test]
fn decisions_and_commands_that_are_no_numbers_are_counted_named_and_mean_hold() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_up();
    assert_eq!(cell.ask(&["task", "start"]).code, 0);
    let nan = |decision: &mut Decision| {
        decision.arm_count = 1;
        decision.goals[0].target = Pose::IDENTITY;
        decision.goals[0].target.position[1] = f64::NAN;
    };
    send(&cell, TopicId::Decision, nan, |bus| {
        let (refused, note) = note(bus, Process::Controller(0));
        let status: ArmStatus = newest(bus, TopicId::ArmStatus(0));
        let holds = status.stop_action == StopAction::Hold.code()
            && status.stop_cause == StopCause::DecisionLost.code();
        refused > 3 && note.starts_with("refused a decision: position[1] is NaN") && holds
    });
    let far = |command: &mut ArmCommand| {
        command.joint_count = 7;
        command.joint_positions[3] = 1.0e30;
    };
    send(&cell, TopicId::ArmCommand(0), far, |bus| {
        let (refused, note) = note(bus, Process::Physics);
        let state: WorldState = newest(bus, TopicId::WorldState);
        let holds = state.arms()[0].stop_action >= StopAction::Hold.code();
        refused > 3 && holds && note.starts_with("refused a command: joint_positions[3] is 1")
    });
    let status = cell.wait_up();
    assert_eq!(status["limit_violations"], 0);
    for name in NAMES {
        assert_eq!(generation(&status, name), 1, "{name} was not restarted");
    }
}

#[test]
fn random_bytes_of_the_right_type_end_no_process() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--no-watchdog"]);
    cell.wait_up();
    let mut state = 7_u64;
    let mut scramble = move |bytes: usize| -> Vec<u8> {
        let words = (0..bytes.div_ceil(8)).map(|_| {
            // A generator of its own: bytes of fractions are not random.
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state.to_le_bytes()
        });
        words.flatten().take(bytes).collect()
    };
    let mut left = 200;
    send(
        &cell,
        TopicId::Decision,
        |decision: &mut Decision| {
            *decision = Decision::from_bytes(&scramble(size_of::<Decision>())).unwrap();
        },
        |bus| {
            left -= 1;
            left < 0 && note(bus, Process::Controller(0)).0 > 100
        },
    );
    let status = cell.wait_up();
    assert_eq!(status["limit_violations"], 0);
    for name in NAMES {
        assert_eq!(generation(&status, name), 1, "{name} was not restarted");
    }
}
