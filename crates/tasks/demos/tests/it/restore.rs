//! A task that ends at any moment is continued by a new one from its checkpoint.

use crate::common;

use cell_model::{Cell, Data};
use common::{ALL, BLUE, FakeCell, RED};
use ipc_types::GripperGoal;
use ipc_types::decision::Outcome;
use robocell_task::CheckpointError;
use robocell_task::checkpoint::VERSION;

fn disturb(cell: &mut FakeCell, step: usize) {
    match step {
        90 => cell.drag(RED, [0.4, -0.1, 0.025]),
        900 => cell.drag(RED, [0.5, 0.0, 0.025]),
        1200 => cell.drag(BLUE, [0.6, -0.2, 0.025]),
        1500..1600 => cell.state.panel.task_paused = 1,
        1600 => cell.state.panel.task_paused = 0,
        _ => {}
    }
}

#[test]
fn a_task_restored_before_every_decision_decides_the_same() {
    for policy in ALL {
        let (mut whole, mut restarted) = (FakeCell::stack(policy), FakeCell::stack(policy));
        restarted.restart_always = true;
        for step in 0..6000 {
            for cell in [&mut whole, &mut restarted] {
                disturb(cell, step);
                cell.step();
            }
            assert_eq!(whole.decision, restarted.decision, "{policy}, step {step}");
        }
        assert_eq!(whole.lines, restarted.lines);
        assert_eq!(whole.outcome(), Outcome::Done);
    }
}

#[test]
fn decisions_missed_with_a_cube_in_the_hand_lose_nothing() {
    for policy in ALL {
        for phase in ["GRASP", "LIFT", "TRANSPORT", "LOWER", "RELEASE", "RETRACT"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until(60.0, |c| c.phase() == phase);
            // The controller continues with the last goal meanwhile.
            (0..40).for_each(|_| cell.move_on());
            cell.restart();
            cell.task.reconcile(&cell.state);
            cell.run_to_done();
            assert_eq!(
                (cell.decision.drops, cell.decided().len()),
                (0, 5),
                "{policy} {phase}"
            );
        }
    }
}

#[test]
fn a_policy_of_another_kind_goes_on_with_the_cube_in_the_hand() {
    for [from, to] in [["fsm", "ifelse"], ["ifelse", "fsm"]] {
        for phase in ["PRE_GRASP", "LIFT", "TRANSPORT", "LOWER", "RETRACT"] {
            let mut cell = FakeCell::stack(from);
            cell.run_until_carrying(BLUE, "GRASP");
            cell.run_until(60.0, |c| c.phase() == phase);
            let entries = cell.decision.phase_entry;
            cell.restart_as(to);
            cell.step();
            assert!(cell.decision.phase_entry > entries);
            if cell.grip.is_some() {
                assert_eq!(cell.phase(), "LIFT");
                assert_eq!(cell.decision.goals[0].gripper, GripperGoal::Close.code());
            }
            cell.run_to_done();
            assert_eq!(cell.decision.drops, 0, "{from} {phase}: {:#?}", cell.lines);
        }
    }
}

#[test]
fn an_aborted_transfer_stays_aborted_for_the_other_policy() {
    let mut cell = FakeCell::stack("fsm");
    cell.run_until_carrying(BLUE, "LIFT");
    cell.drag(RED, [0.42, 0.05, 0.025]);
    cell.run_until(10.0, |c| c.phase() == "TRANSPORT");
    assert_eq!(cell.decision.aborts, 1);
    cell.restart_as("ifelse");
    cell.run_to_done();
    assert_eq!(cell.decision.aborts, 1);
    assert_eq!(cell.decided()[2..4], ["stack red_cube", "stack blue_cube"]);
}

#[test]
fn without_a_record_the_task_sees_what_is_in_the_hand() {
    for policy in ALL {
        for phase in ["LIFT", "TRANSPORT", "LOWER"] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until_carrying(BLUE, phase);
            cell.task = demos::policies().task(&cell.cell, policy).unwrap();
            cell.step();
            assert_eq!(
                (cell.phase(), cell.count("[resume] blue_cube")),
                ("LIFT", 1)
            );
            assert_eq!(cell.decision.goals[0].gripper, GripperGoal::Close.code());
            cell.run_to_done();
            assert_eq!(cell.decision.drops, 0);
        }
    }
}

#[test]
fn damaged_and_foreign_records_are_refused_and_change_nothing() {
    let mut cell = FakeCell::stack("fsm");
    cell.run_until_carrying(RED, "LIFT");
    let record = cell.task.checkpoint();
    let mut task = demos::policies().task(&cell.cell, "fsm").unwrap();
    let before = task.checkpoint();
    for len in 0..record.len() {
        assert!(task.restore(&record[..len]).is_err(), "cut to {len} bytes");
    }
    let longer = [record.as_slice(), &[0]].concat();
    assert!(matches!(
        task.restore(&longer),
        Err(CheckpointError::Unreadable(_))
    ));
    let newer = [&(VERSION + 1).to_le_bytes(), &record[4..]].concat();
    assert!(matches!(
        task.restore(&newer),
        Err(CheckpointError::Version { found }) if found == VERSION + 1
    ));
    let reach = Cell::load(&Data::checkout(), "reach", 1, None).unwrap();
    let foreign = demos::policies()
        .task(&reach, "follow")
        .unwrap()
        .checkpoint();
    assert!(matches!(
        task.restore(&foreign),
        Err(CheckpointError::OtherCell { .. })
    ));
    assert_eq!(task.checkpoint(), before);
}

#[test]
fn no_flipped_byte_of_a_record_makes_the_task_panic() {
    let mut cell = FakeCell::stack("fsm");
    cell.run_until_carrying(RED, "LIFT");
    let record = cell.task.checkpoint();
    for index in 0..record.len() {
        for value in [0x00, 0x7f, 0xff] {
            let mut broken = record.clone();
            broken[index] = value;
            let mut task = demos::policies().task(&cell.cell, "fsm").unwrap();
            if task.restore(&broken).is_ok() {
                task.decide(&cell.state, &[], &mut cell.decision, &mut Vec::new());
            }
        }
    }
}
