//! The checkpoint of a cycle is refused where it does not fit.

use cell_model::{Cell, Data};
use controller_proc::checkpoint::{CheckpointError, VERSION};
use controller_proc::cycle::Cycle;
use ipc_types::tap::KEYFRAME_BYTES;

fn cycle(demo: &str, arm: usize) -> Cycle {
    let cell = Cell::load(&Data::checkout(), demo, 1, None).expect("a cell");
    Cycle::new(&cell, arm).expect("a controller")
}

fn saved(cycle: &mut Cycle) -> Vec<u8> {
    let mut bytes = vec![0; KEYFRAME_BYTES];
    let length = cycle.save(30, &mut bytes).expect("room");
    bytes.truncate(length);
    bytes
}

#[test]
fn a_record_goes_there_and_back_with_the_age_limit() {
    let bytes = saved(&mut cycle("franka-pyramid", 1));
    assert!(bytes.len() < KEYFRAME_BYTES / 4, "{} bytes", bytes.len());
    let mut other = cycle("franka-pyramid", 1);
    assert_eq!(other.restore(&bytes), Ok(30));
    assert_eq!(saved(&mut other), bytes);
}

#[test]
fn another_arm_another_cell_and_another_version_are_refused() {
    let bytes = saved(&mut cycle("franka-pyramid", 0));
    let arm = cycle("franka-pyramid", 1).restore(&bytes);
    assert!(
        matches!(
            arm,
            Err(CheckpointError::OtherArm {
                what: "arm number",
                ..
            })
        ),
        "{arm:?}"
    );
    let cell = cycle("franka-stack", 0).restore(&bytes);
    assert!(
        matches!(
            cell,
            Err(CheckpointError::OtherArm {
                what: "other arms",
                ..
            })
        ),
        "{cell:?}"
    );
    let mut newer = bytes;
    newer[0] += 1;
    let version = cycle("franka-pyramid", 0).restore(&newer);
    assert_eq!(
        version,
        Err(CheckpointError::Version { found: VERSION + 1 })
    );
}

#[test]
fn no_bytes_whatever_make_a_controller_that_panics() {
    let whole = saved(&mut cycle("franka-stack", 0));
    assert!(cycle("franka-stack", 0).save(30, &mut [0; 100]).is_err());
    for length in [0, 3, 4, 50, whole.len() - 1] {
        assert!(cycle("franka-stack", 0).restore(&whole[..length]).is_err());
    }
    let mut long = whole.clone();
    long.push(0);
    assert!(cycle("franka-stack", 0).restore(&long).is_err());
    // Nonsense anywhere is refused or taken, and then calculated with.
    let (mut state, mut decision) = scene();
    for at in (0..whole.len()).step_by(61) {
        let mut bytes = whole.clone();
        bytes[at] = 0xff;
        let mut cycle = cycle("franka-stack", 0);
        if cycle.restore(&bytes).is_ok() {
            for tick in 0..3 {
                state.header.tick = tick;
                decision.header.tick = tick;
                let (mut command, mut status) = answers();
                cycle.update(&state, Some(&decision), 30, &mut command, &mut status);
            }
        }
    }
}

fn answers() -> (ipc_types::ArmCommand, ipc_types::ArmStatus) {
    use ipc_types::Wire as _;
    (
        ipc_types::ArmCommand::zeroed(),
        ipc_types::ArmStatus::zeroed(),
    )
}

fn scene() -> (Box<ipc_types::WorldState>, Box<ipc_types::Decision>) {
    use ipc_types::Wire as _;
    let mut state = Box::new(ipc_types::WorldState::zeroed());
    state.arm_count = 1;
    state.arms[0].joint_count = 7;
    state.arms[0].tcp = ipc_types::Pose::IDENTITY;
    let mut decision = Box::new(ipc_types::Decision::zeroed());
    decision.arm_count = 1;
    decision.goals[0].kind = 1;
    decision.goals[0].target = ipc_types::Pose::IDENTITY;
    (state, decision)
}
