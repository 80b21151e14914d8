//! Effects of the operator's panel on a task.

use crate::common;

use cell_model::{Cell, Data};
use common::{ALL, FakeCell, RED, minus, norm};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{GripperGoal, Pose};
use robocell_task::TaskError;

const UP: Pose = Pose {
    position: [0.4, 0.1, 0.5],
    orientation_wxyz: [0.0, 0.8, 0.6, 0.0],
};

fn target(cell: &mut FakeCell, pose: Pose) {
    cell.state.panel.target_seq += 1;
    cell.state.panel.target = pose;
}

fn gripper(cell: &mut FakeCell, goal: GripperGoal) {
    cell.state.panel.gripper_seq += 1;
    cell.state.panel.gripper = goal.code();
}

#[test]
fn a_paused_task_holds_until_the_operator_leads_and_then_goes_on() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        // Asked before the pause, so it does not count in it.
        target(&mut cell, UP);
        cell.run_until_carrying(RED, "TRANSPORT");
        assert_ne!(cell.decision.goals[0].target, UP);
        cell.state.panel.task_paused = 1;
        cell.step();
        let goal = cell.decision.goals[0];
        assert_eq!(
            (goal.kind, goal.gripper),
            (GoalKind::Hold.code(), GripperGoal::Keep.code())
        );
        assert_eq!(
            (cell.outcome(), cell.phase()),
            (Outcome::Paused, "TRANSPORT")
        );
        target(&mut cell, UP);
        cell.step();
        let led = cell.decision.goals[0];
        assert_eq!((led.kind, led.target), (GoalKind::Pose.code(), UP));
        assert!(led.goal_id > goal.goal_id);
        let time = cell.task.time();
        (0..1000).for_each(|_| cell.step());
        assert_eq!(cell.task.time(), time, "deadlines are frozen");
        assert!(norm(minus(cell.state.arms[0].tcp.position, UP.position)) < 1e-9);
        cell.state.panel.task_paused = 0;
        cell.run_to_done();
        assert_eq!(cell.decision.drops, 0);
    }
}

#[test]
fn a_cube_taken_by_hand_in_a_pause_is_carried_on() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        cell.run_until(60.0, |c| c.phase() == "PRE_GRASP");
        cell.state.panel.task_paused = 1;
        cell.step();
        let at = Pose {
            position: cell.position(RED),
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
        target(&mut cell, at);
        (0..100).for_each(|_| cell.step());
        gripper(&mut cell, GripperGoal::Close);
        (0..100).for_each(|_| cell.step());
        target(&mut cell, UP);
        (0..100).for_each(|_| cell.step());
        assert_eq!(cell.decision.goals[0].gripper, GripperGoal::Close.code());
        assert!(cell.grip.is_some());
        cell.state.panel.task_paused = 0;
        cell.step();
        assert_eq!(cell.phase(), "LIFT");
        cell.run_to_done();
        assert_eq!(
            (cell.decision.drops, cell.decided()[1]),
            (0, "stack blue_cube")
        );
    }
}

#[test]
fn a_reset_begins_anew_with_new_goal_numbers() {
    for policy in ALL {
        for scene in [false, true] {
            let mut cell = FakeCell::stack(policy);
            cell.run_until(60.0, |c| c.phase() == "APPROACH");
            let goal_id = cell.decision.goals[0].goal_id;
            let panel = &mut cell.state.panel;
            *(if scene {
                &mut panel.scene_reset
            } else {
                &mut panel.task_reset
            }) += 1;
            cell.step();
            assert_eq!((cell.phase(), cell.decision.phase_entry), ("PRE_GRASP", 1));
            assert!(cell.decision.goals[0].goal_id > goal_id);
            cell.run_to_done();
        }
    }
}

#[test]
fn a_reset_that_pauses_opens_the_hand_and_sends_the_arm_home_until_the_operator_leads() {
    for policy in ALL {
        let mut cell = FakeCell::stack(policy);
        let home = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
        target(&mut cell, UP);
        cell.run_until_carrying(RED, "TRANSPORT");
        cell.state.panel.task_paused = 1;
        target(&mut cell, UP);
        cell.step();
        cell.state.panel.task_reset += 1;
        cell.step();
        let goal = cell.decision.goals[0];
        assert_eq!(
            (goal.kind, goal.gripper),
            (GoalKind::Hold.code(), GripperGoal::Open.code()),
            "{policy}: it opens at once, and what it was asked before is cleared"
        );
        (0..60).for_each(|_| cell.step());
        cell.restart();
        cell.step();
        let goal = cell.decision.goals[0];
        assert_eq!(goal.kind, GoalKind::Joints.code(), "{policy}");
        assert_eq!(goal.posture[..7], home.arms[0].home[..]);
        assert_eq!(goal.gripper, GripperGoal::Open.code());
        assert_eq!(cell.outcome(), Outcome::Paused);
        let low = Pose {
            position: [0.5, 0.0, 0.3],
            ..UP
        };
        target(&mut cell, low);
        cell.step();
        assert_eq!(cell.decision.goals[0].target, low);
        cell.state.panel.task_paused = 0;
        cell.step();
        assert_eq!(cell.phase(), "PRE_GRASP");
        cell.run_to_done();
    }
}

#[test]
fn follow_goes_where_the_operator_points_paused_or_not() {
    let mut cell = FakeCell::new("reach", "follow", 1);
    cell.step();
    assert_eq!(cell.decision.goals[0].kind, GoalKind::Hold.code());
    assert_eq!((cell.phase(), cell.outcome()), ("FOLLOW", Outcome::Running));
    target(&mut cell, UP);
    gripper(&mut cell, GripperGoal::Close);
    cell.step();
    let first = cell.decision.goals[0];
    assert_eq!(
        (first.target, first.gripper),
        (UP, GripperGoal::Close.code())
    );
    assert!(first.grip_force > 0.0);
    cell.restart();
    cell.step();
    assert_eq!(
        cell.decision.goals[0], first,
        "said again, it is the same goal"
    );
    cell.state.panel.task_paused = 1;
    let low = Pose {
        position: [0.5, 0.0, 0.3],
        ..UP
    };
    target(&mut cell, low);
    cell.step();
    assert_eq!(
        (cell.decision.goals[0].target, cell.outcome()),
        (low, Outcome::Paused)
    );
    assert_eq!(cell.decision.goals[0].goal_id, first.goal_id + 1);
}

#[test]
fn the_first_target_of_reach_keeps_the_orientation_it_finds() {
    let file = include_str!("../../../../../cells/reach.toml");
    let file = file.replace(
        "kind = \"reach\"",
        "kind = \"reach\"\nposition_m = [0.3, 0.2, 0.5]",
    );
    let cell = Cell::from_text(&Data::checkout(), "reach", "reach.toml", &file, 1, None).unwrap();
    let mut fake = FakeCell::new("reach", "follow", 1);
    fake.task = demos::policies().task(&cell, "follow").unwrap();
    fake.state.arms[0].tcp = UP;
    fake.step();
    let goal = fake.decision.goals[0];
    assert_eq!(
        (goal.kind, goal.target.position),
        (GoalKind::Pose.code(), [0.3, 0.2, 0.5])
    );
    assert_eq!(goal.target.orientation_wxyz, UP.orientation_wxyz);
}

#[test]
fn an_unknown_policy_gets_advice() {
    let stack = Cell::load(&Data::checkout(), "franka-stack", 1, None).unwrap();
    let message = |policy| match demos::policies().task(&stack, policy) {
        Err(error @ TaskError::UnknownPolicy { .. }) => error.to_string(),
        _ => panic!("'{policy}' was taken"),
    };
    assert_eq!(
        message("fms"),
        "unknown policy 'fms' for demo 'franka-stack'; did you mean 'fsm'?"
    );
    assert!(message("zzz").ends_with("known are: fsm, ifelse, bt"));
}
