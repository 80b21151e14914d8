//! Size and alignment of every message: a change here is a change of the
//! contract and belongs into the changelog.

mod damage;

use ipc_types::*;

#[test]
fn sizes_are_the_published_ones() {
    let sizes = [
        ("Header", size_of::<Header>()),
        ("WorldState", size_of::<WorldState>()),
        ("Contacts", size_of::<Contacts>()),
        ("ArmCommand", size_of::<ArmCommand>()),
        ("ArmStatus", size_of::<ArmStatus>()),
        ("Decision", size_of::<Decision>()),
        ("TraceLine", size_of::<TraceLine>()),
        ("Health", size_of::<Health>()),
        ("OperatorRequest", size_of::<OperatorRequest>()),
        ("OperatorReply", size_of::<OperatorReply>()),
    ];
    let listed: Vec<String> = sizes.iter().map(|(n, s)| format!("{n} {s}")).collect();
    assert_eq!(listed.join("\n"), include_str!("sizes.txt").trim_end());
}

#[test]
fn every_message_of_zeros_but_poses_names_its_bad_field() {
    let mut state = WorldState::zeroed();
    assert!(state.validate().is_ok());
    state.arm_count = 3;
    assert_eq!(state.validate().unwrap_err().field, "arm_count");
    state.arm_count = 1;
    assert_eq!(state.validate().unwrap_err().field, "orientation_wxyz");
}

#[test]
fn non_finite_and_absurd_numbers_are_refused_by_name() {
    let mut command = ArmCommand::zeroed();
    command.joint_count = 7;
    assert!(command.validate().is_ok());
    for bad in [f64::NAN, f64::INFINITY, -1.0e30] {
        command.joint_positions[3] = bad;
        let error = command.validate().unwrap_err();
        assert_eq!((error.field, error.index), ("joint_positions", 3));
        // What lies beyond the count is not part of the message.
        command.joint_count = 3;
        assert!(command.validate().is_ok());
        command.joint_count = 7;
    }
}

#[test]
fn unknown_codes_are_refused() {
    let mut decision = Decision::zeroed();
    decision.outcome = 99;
    assert_eq!(decision.validate().unwrap_err().field, "outcome");
}
