//! The interface without sockets: its checkpoint, and what a cycle costs.

use cell_model::{Cell, Data};
use cell_rt::alloc::count;
use fci_proc::cycle::{CheckpointError, Cycle};
use ipc_types::arm::StopAction;
use ipc_types::client::ClientEvent;
use ipc_types::tap::KEYFRAME_BYTES;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Wire, WorldState};

/// A pose within the limits (rad).
const HOME: [f64; 7] = [0.0, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8];

fn cycle() -> Cycle {
    let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).expect("a cell");
    Cycle::new(&cell, 0).expect("an interface")
}

fn state(tick: u64) -> WorldState {
    let mut state = WorldState::zeroed();
    state.header.generation = 1;
    state.header.tick = tick;
    state.header.seq = tick + 1;
    state.arm_count = 1;
    for (joint, position) in HOME.into_iter().enumerate() {
        state.arms[0].joint_positions[joint] = position;
        state.arms[0].setpoint_positions[joint] = position;
    }
    state
}

/// A request or command of a client, with number `seq`.
fn input(seq: u64, event: ClientEvent, bytes: &[u8]) -> ClientInput {
    let mut input = ClientInput::zeroed();
    input.header.generation = 1;
    input.header.seq = seq;
    input.event = event.code();
    input.is_awaited = 1;
    input.len = u32::try_from(bytes.len()).unwrap();
    input.bytes[..bytes.len()].copy_from_slice(bytes);
    input
}

/// The request for a motion of joint velocities.
fn motion(seq: u64) -> ClientInput {
    let mut bytes = vec![0; 125];
    bytes[0] = 1;
    bytes[8] = 125;
    bytes[16] = 1;
    input(seq, ClientEvent::Request, &bytes)
}

/// A command that answers the state `message_id`.
fn command(seq: u64, message_id: u64) -> ClientInput {
    let mut bytes = [0; 371];
    bytes[..8].copy_from_slice(&message_id.to_le_bytes());
    input(seq, ClientEvent::Command, &bytes)
}

fn update(cycle: &mut Cycle, tick: u64) -> (ArmCommand, ArmStatus) {
    let (mut command, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
    assert!(cycle.update(&state(tick), &mut command, &mut status));
    cycle.discard_replies();
    (command, status)
}

/// A client that moves, in its tick 20.
fn moving() -> Cycle {
    let mut cycle = cycle();
    update(&mut cycle, 1);
    cycle.take(&input(1, ClientEvent::Connected, &[]), None);
    cycle.take(&motion(2), None);
    cycle.discard_replies();
    assert!(cycle.robot().is_moving());
    for tick in 2..20 {
        update(&mut cycle, tick);
        cycle.take(&command(tick + 1, cycle.robot().message_id()), None);
    }
    assert!(cycle.robot().is_running());
    cycle
}

fn saved(cycle: &Cycle) -> Vec<u8> {
    let mut bytes = vec![0; KEYFRAME_BYTES];
    let length = cycle.save(&mut bytes).expect("room");
    bytes.truncate(length);
    bytes
}

#[test]
fn an_interface_continues_from_its_checkpoint_in_the_middle_of_a_motion() {
    let mut one = moving();
    let bytes = saved(&one);
    assert!(bytes.len() < KEYFRAME_BYTES / 4, "{} bytes", bytes.len());
    let mut other = cycle();
    other.restore(&bytes).expect("its own checkpoint");
    assert_eq!(saved(&other), bytes);
    for tick in 20..60 {
        let (command, status) = update(&mut one, tick);
        let (again, status_again) = update(&mut other, tick);
        assert_eq!(command.as_bytes(), again.as_bytes(), "tick {tick}");
        assert_eq!(status.as_bytes(), status_again.as_bytes(), "tick {tick}");
    }
    // The client did not answer any more.
    assert_eq!(update(&mut one, 60).1.client.failures, 1);
}

#[test]
fn a_motion_that_its_client_did_not_end_is_a_failure_with_a_name() {
    let ended = |cycle: &mut Cycle| update(cycle, 21).1.client;
    let mut one = moving();
    one.take(&input(50, ClientEvent::Ended, &[]), None);
    let client = ended(&mut one);
    assert_eq!((client.failures, client.ended), (1, 1));
    assert_eq!(client.failure.as_str(), "client_ended_in_motion");
    // At rest it may end.
    one.take(&input(51, ClientEvent::Connected, &[]), None);
    one.take(&input(52, ClientEvent::Ended, &[]), None);
    let client = ended(&mut one);
    assert_eq!((client.failures, client.ended), (1, 2));

    let mut held = moving();
    let mut state = state(20);
    state.arms[0].stop_action = StopAction::Hold.code();
    let (mut command, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
    assert!(held.update(&state, &mut command, &mut status));
    assert!(held.take_held() && !held.take_held() && !held.robot().is_moving());
    assert_eq!(status.client.failure.as_str(), "drives_held");
}

#[test]
fn no_bytes_whatever_make_an_interface_that_panics() {
    let whole = saved(&moving());
    assert!(cycle().save(&mut [0; 100]).is_err());
    for length in [0, 3, 4, 50, whole.len() - 1] {
        assert!(cycle().restore(&whole[..length]).is_err(), "{length}");
    }
    let mut long = whole.clone();
    long.push(0);
    assert!(cycle().restore(&long).is_err());
    let mut newer = whole.clone();
    newer[0] += 1;
    let refused = cycle().restore(&newer);
    assert!(
        matches!(refused, Err(CheckpointError::Version(3))),
        "{refused:?}"
    );
    // Nonsense anywhere is refused or taken, and then calculated with.
    let mut cycle = cycle();
    for at in (4..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[at] = 0xff;
        if cycle.restore(&bytes).is_ok() {
            for tick in 20..23 {
                cycle.take(&command(tick, cycle.robot().message_id()), None);
                update(&mut cycle, tick);
            }
        }
    }
}

#[test]
fn neither_an_input_nor_a_cycle_nor_a_checkpoint_allocates() {
    let mut cycle = moving();
    let mut bytes = vec![0; KEYFRAME_BYTES];
    let (mut sent, mut report) = (ArmCommand::zeroed(), ArmStatus::zeroed());
    let mut state = state(20);
    let before = count();
    for tick in 20..40 {
        state.header.tick = tick;
        let answer = command(tick, cycle.robot().message_id());
        cycle.take(&answer, Some(&state));
        assert!(cycle.update(&state, &mut sent, &mut report));
        cycle.discard_replies();
        assert!(cycle.save(&mut bytes).is_ok());
    }
    assert_eq!(count() - before, 0);
    assert!(cycle.robot().is_running());
}
