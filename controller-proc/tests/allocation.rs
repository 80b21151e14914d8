//! A cycle allocates nothing: not when it follows, not when it switches the
//! gripper, not when it holds.

#![allow(clippy::expect_used, reason = "a test that cannot go on has failed")]

use cell_model::{Cell, Data};
use cell_rt::alloc::{Counting, count};
use controller_proc::cycle::Cycle;
use ipc_types::decision::GoalKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, GripperGoal, Pose, Wire, WorldState};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn no_cycle_allocates() {
    let cell = Cell::load(&Data::embedded(), "franka-stack", 1, None).expect("a cell");
    let mut cycle = Cycle::new(&cell, 0).expect("a controller");
    let mut state = Box::new(WorldState::zeroed());
    state.header.generation = 1;
    state.arm_count = 1;
    state.arms[0].joint_count = 7;
    state.arms[0].tcp = Pose::IDENTITY;
    for (slot, home) in cell.arms[0].home.iter().enumerate() {
        state.arms[0].joint_positions[slot] = *home;
        state.arms[0].setpoint_positions[slot] = *home;
    }
    let mut decision = Decision::zeroed();
    decision.arm_count = 1;
    let goal = &mut decision.goals[0];
    goal.kind = GoalKind::Pose.code();
    goal.target.position = [0.5, 0.2, 0.3];
    goal.target.orientation_wxyz = [0.0, 1.0, 0.0, 0.0];
    goal.approach = [0.0, 0.0, -0.1];
    goal.approach_std_dev = 0.02;
    let (mut command, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
    let before = count();
    for tick in 0..600 {
        state.header.tick = tick;
        // The last third is a task that fell silent.
        if tick < 400 {
            decision.header.tick = tick;
            let closed = tick >= 200;
            let gripper = if closed {
                GripperGoal::Close
            } else {
                GripperGoal::Open
            };
            decision.goals[0].gripper = gripper.code();
        }
        cycle.update(&state, Some(&decision), 30, &mut command, &mut status);
        state.arms[0].joint_positions = command.joint_positions;
    }
    assert_eq!(count() - before, 0, "allocations in 600 cycles");
    assert_ne!(status.stop_action, 0, "the last cycles hold");
}
