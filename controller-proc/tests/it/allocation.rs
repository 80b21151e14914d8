//! A cycle allocates nothing: not when it follows, not when it switches the
//! gripper, not when it holds; and neither does writing its checkpoint.

use crate::support;

use cell_model::{Cell, Data};
use cell_rt::alloc::count;
use controller_proc::cycle::Cycle;
use controller_proc::planning::Planner;
use ipc_types::arm::PlanState;
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmCommand, ArmStatus, Decision, GripperGoal, Pose, Wire, WorldState};

#[test]
fn no_cycle_allocates() {
    run("franka-stack");
    run("franka-pyramid");
    run_ur10();
}

/// A UR10 among bins that move, come and go, and are picked up.
fn run_ur10() {
    let mut bench = support::Bench::new();
    bench.goal([0.4, 0.6, 0.2], support::down(0.3));
    bench.gripper(GripperGoal::Close);
    bench.tick(true);
    let mut record = vec![0; ipc_types::tap::KEYFRAME_BYTES];
    let hanging = nalgebra::Isometry3::translation(0.0735, 0.0, 0.0);
    let before = count();
    for tick in 0..600_u32 {
        bench.decision.goals[0].object_mask = u64::from(tick / 7);
        bench.put(1, [0.3, 0.5 + 1.0e-3 * f64::from(tick), 0.1]);
        match tick % 100 {
            20 => bench.attach(0, &hanging),
            70 => bench.detach(),
            _ => {}
        }
        bench.state.header.tick += 1;
        bench.cycle.update(
            &bench.state,
            Some(&bench.decision),
            1_000,
            &mut bench.command,
            &mut bench.status,
        );
        bench.state.arms[0].joint_positions = bench.command.joint_positions;
        bench.cycle.save(30, &mut record).expect("room");
    }
    assert_eq!(count() - before, 0, "allocations among bins");
    assert_eq!(bench.status.stop_action, 0, "it was at work");
}

/// A Panda that requests a path and follows it.
#[test]
fn no_cycle_with_a_planner_allocates() {
    let cell = Cell::load(&Data::checkout(), "reach-shelf", 1, None).expect("a cell");
    let mut cycle = Cycle::new(&cell, 0).expect("a controller");
    let mut planner = Planner::new(&cell, 0).expect("a planner");
    let mut state = Box::new(WorldState::zeroed());
    (state.header.generation, state.arm_count, state.object_count) = (1, 1, 1);
    state.objects[0].flags = OBJECT_ENABLED;
    state.objects[0].pose = Pose::IDENTITY;
    state.objects[0].pose.position = [0.1, -0.65, 0.25];
    state.arms[0].joint_count = 7;
    state.arms[0].tcp = Pose::IDENTITY;
    let left = [0.4, 0.3, 0.0, -1.9, 0.0, 2.2, 1.2];
    state.arms[0].joint_positions[..7].copy_from_slice(&left);
    state.arms[0].setpoint_positions[..7].copy_from_slice(&left);
    let mut decision = Box::new(Decision::zeroed());
    (decision.header.generation, decision.arm_count) = (1, 1);
    decision.goals[0].kind = GoalKind::Pose.code();
    decision.goals[0].goal_id = 1;
    decision.goals[0].obstacle_mask = u64::MAX;
    decision.goals[0].object_mask = u64::MAX;
    decision.goals[0].target = Pose {
        position: [0.55, -0.25, 0.25],
        orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
    };
    let (mut command, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
    let mut record = vec![0; ipc_types::tap::KEYFRAME_BYTES];
    let mut request = cycle.empty_plan_request();
    let (mut allocated, mut led) = (0, 0);
    for tick in 0..2_000 {
        state.header.tick = tick;
        decision.header.tick = tick;
        cycle.plan_with(&mut planner, tick);
        let before = count();
        cycle.update(&state, Some(&decision), 1_000, &mut command, &mut status);
        cycle.save(30, &mut record).expect("room");
        cycle.copy_plan_request(&mut request);
        allocated += count() - before;
        state.arms[0].joint_positions = command.joint_positions;
        state.arms[0].setpoint_positions = command.joint_positions;
        led += usize::from(status.plan_state == PlanState::Led.code());
    }
    assert!(led > 1_000, "led in {led} cycles: {status:?}");
    assert_eq!(allocated, 0, "allocations in 2000 cycles");
}

/// Arm 0 of a demo at work, with every other arm at home.
fn run(demo: &str) {
    let cell = Cell::load(&Data::checkout(), demo, 1, None).expect("a cell");
    let mut cycle = Cycle::new(&cell, 0).expect("a controller");
    let mut state = Box::new(WorldState::zeroed());
    state.header.generation = 1;
    for (arm, spec) in state.arms.iter_mut().zip(&cell.arms) {
        state.arm_count += 1;
        arm.joint_count = 7;
        arm.tcp = Pose::IDENTITY;
        arm.joint_positions[..7].copy_from_slice(&spec.home);
        arm.setpoint_positions[..7].copy_from_slice(&spec.home);
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
    let mut record = vec![0; ipc_types::tap::KEYFRAME_BYTES];
    let before = count();
    for tick in 0..600 {
        state.header.tick = tick;
        // The last third is a task that fell silent.
        if tick < 400 {
            decision.header.tick = tick;
            let closed = tick >= 200;
            // Every controller has its turn.
            decision.goals[0].selector = u32::try_from(tick / 100).unwrap_or(0) % 3;
            decision.goals[0].has_posture = 1;
            let gripper = if closed {
                GripperGoal::Close
            } else {
                GripperGoal::Open
            };
            decision.goals[0].gripper = gripper.code();
        }
        cycle.update(&state, Some(&decision), 30, &mut command, &mut status);
        state.arms[0].joint_positions = command.joint_positions;
        let length = cycle
            .save(30, &mut record)
            .expect("room for the checkpoint");
        assert!(length > 0);
    }
    assert_eq!(count() - before, 0, "allocations in 600 cycles");
    assert_ne!(status.stop_action, 0, "the last cycles hold");
}
