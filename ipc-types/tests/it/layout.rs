//! Layout of every message: a change here is a change of the
//! contract and needs a file in `changes/`.

use std::fmt::Write as _;

use ipc_types::layout_of;
use ipc_types::*;

/// Programs in other languages read these layouts: a change needs a line "Migration:" in a
/// file of `changes/`. `contract.txt` is edited by hand.
#[test]
fn names_types_and_offsets_are_the_published_ones() {
    let mut structs = Vec::new();
    for layouts in [
        layout_of::<WorldState>(),
        layout_of::<Contacts>(),
        layout_of::<ArmCommand>(),
        layout_of::<ArmStatus>(),
        layout_of::<Decision>(),
        layout_of::<TraceLine>(),
        layout_of::<Health>(),
        layout_of::<OperatorRequest>(),
        layout_of::<OperatorReply>(),
    ] {
        for layout in layouts {
            if !structs.contains(&layout) {
                structs.push(layout);
            }
        }
    }
    let mut listed = String::new();
    for layout in structs {
        writeln!(listed, "{} {}", layout.name, layout.bytes).unwrap();
        for field in layout.fields {
            let (offset, name, element, count) =
                (field.offset, field.name, field.element, field.count);
            writeln!(listed, "  {offset} {name}: {element} x {count}").unwrap();
        }
    }
    let published = include_str!("../contract.txt");
    for (is, was) in listed.lines().zip(published.lines()) {
        assert_eq!(is, was, "ipc-types/tests/contract.txt");
    }
    assert_eq!(listed.lines().count(), published.lines().count());
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
        // Entries beyond the count are not part of the message.
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
