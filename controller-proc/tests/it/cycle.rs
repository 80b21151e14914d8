//! The cycle against a plain world in which the drives make the commanded motion exactly.

use cell_model::{Cell, Data};
use controller_proc::controllers::{LINE, RMPFLOW};
use controller_proc::cycle::Cycle;
use ipc_types::arm::{StopAction, StopCause};
use ipc_types::decision::GoalKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, GripperGoal, Header, Pose, Wire, WorldState};

const LIMIT: u64 = 30;

struct Bench {
    cell: Cell,
    cycle: Cycle,
    state: WorldState,
    decision: Decision,
    command: ArmCommand,
    status: ArmStatus,
}

impl Bench {
    fn new() -> Self {
        let cell = Cell::load(&Data::checkout(), "franka-stack", 1, None).expect("a cell");
        let mut state = WorldState::zeroed();
        state.header.generation = 1;
        state.arm_count = 1;
        let arm = &mut state.arms[0];
        arm.joint_count = 7;
        arm.tcp = Pose::IDENTITY;
        arm.gripper.width = 0.08;
        for (slot, home) in cell.arms[0].home.iter().enumerate() {
            arm.joint_positions[slot] = *home;
            arm.setpoint_positions[slot] = *home;
        }
        let mut decision = Decision::zeroed();
        decision.arm_count = 1;
        decision.goals[0].target = Pose::IDENTITY;
        Self {
            cycle: Cycle::new(&cell, 0).expect("a controller"),
            cell,
            state,
            decision,
            command: ArmCommand::zeroed(),
            status: ArmStatus::zeroed(),
        }
    }

    fn goal(&mut self, goal_id: u64, position: [f64; 3], gripper: GripperGoal) {
        let goal = &mut self.decision.goals[0];
        goal.goal_id = goal_id;
        goal.kind = GoalKind::Pose.code();
        goal.gripper = gripper.code();
        goal.target = Pose {
            position,
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
    }

    /// One cycle with a decision of this tick's last tenth; the drives follow.
    fn tick(&mut self, task_alive: bool) {
        if task_alive && self.state.header.tick.is_multiple_of(10) {
            self.decision.header = Header::caused_by::<Decision>(self.state.header.tick);
        }
        self.cycle.update(
            &self.state,
            Some(&self.decision),
            LIMIT,
            &mut self.command,
            &mut self.status,
        );
        let arm = &mut self.state.arms[0];
        arm.joint_positions = self.command.joint_positions;
        arm.joint_velocities = self.command.joint_velocities;
        arm.setpoint_positions = self.command.joint_positions;
        arm.setpoint_velocities = self.command.joint_velocities;
        arm.setpoint_accelerations = self.command.joint_accelerations;
        self.state.header.tick += 1;
    }

    fn speed(&self) -> f64 {
        self.command
            .joint_velocities
            .iter()
            .fold(0.0, |worst, v| v.abs().max(worst))
    }

    /// Runs `ticks` cycles and checks each command against the one before.
    fn run_within_limits(&mut self, ticks: usize, task_alive: bool) {
        let limits = self.cell.arms[0].robot.limits();
        for _ in 0..ticks {
            let before = self.command;
            self.tick(task_alive);
            for joint in 0..7 {
                let quotient = (self.command.joint_velocities[joint]
                    - before.joint_velocities[joint])
                    / 1.0e-3;
                let jerk = (quotient - before.joint_accelerations[joint]) / 1.0e-3;
                assert!(
                    quotient.abs() <= limits.acceleration[joint] * (1.0 + 1.0e-6),
                    "{quotient}"
                );
                assert!(jerk.abs() <= limits.jerk[joint] * (1.0 + 1.0e-6), "{jerk}");
            }
        }
    }
}

#[test]
fn a_goal_is_reached_within_the_limits() {
    let mut bench = Bench::new();
    bench.goal(1, [0.5, 0.2, 0.3], GripperGoal::Open);
    bench.tick(true);
    bench.run_within_limits(4_000, true);
    let setpoint = bench.status.setpoint.position;
    let error: f64 = setpoint
        .iter()
        .zip([0.5, 0.2, 0.3])
        .map(|(a, b)| (a - b) * (a - b))
        .sum();
    assert!(error.sqrt() < 0.005, "{setpoint:?}");
    assert_eq!(
        (bench.status.goal_id, bench.status.stop_action),
        (1, StopAction::None.code())
    );
}

#[test]
fn a_silent_task_means_hold_with_the_gripper_as_it_is_and_a_new_one_goes_on() {
    let mut bench = Bench::new();
    bench.goal(1, [0.5, 0.3, 0.3], GripperGoal::Close);
    bench.tick(true);
    bench.run_within_limits(500, true);
    assert!(bench.speed() > 0.1, "the arm moves");
    bench.run_within_limits(600, false);
    assert_eq!(bench.status.stop_cause, StopCause::DecisionLost.code());
    assert_eq!(bench.command.gripper.width, 0.0, "the hand stays closed");
    assert!(bench.speed() < 0.02, "the arm holds: {}", bench.speed());
    // A new generation with the same goal: nothing jumps, the goal is reached.
    bench.decision.header.generation = 2;
    bench.run_within_limits(4_000, true);
    assert_eq!(bench.status.stop_action, StopAction::None.code());
    assert!((bench.status.setpoint.position[1] - 0.3).abs() < 0.005);
}

#[test]
fn a_controller_that_was_away_goes_on_from_where_physics_stopped_the_arm() {
    let mut bench = Bench::new();
    bench.goal(1, [0.5, 0.3, 0.3], GripperGoal::Open);
    bench.tick(true);
    bench.run_within_limits(500, true);
    // Physics braked meanwhile: another place, at rest.
    let arm = &mut bench.state.arms[0];
    arm.stop_action = StopAction::Hold.code();
    arm.setpoint_positions[0] += 0.04;
    arm.joint_positions[0] += 0.04;
    arm.setpoint_velocities = [0.0; 16];
    arm.setpoint_accelerations = [0.0; 16];
    let stopped_at = arm.setpoint_positions;
    bench.tick(true);
    for (joint, stopped) in stopped_at.iter().enumerate().take(7) {
        let step = bench.command.joint_positions[joint] - stopped;
        assert!(step.abs() < 1.0e-4, "joint {joint} jumps by {step}");
        assert!(bench.command.joint_velocities[joint].abs() < 0.03);
    }
}

#[test]
fn a_new_controller_keeps_a_hand_that_holds_something_closed() {
    let mut bench = Bench::new();
    bench.state.arms[0].gripper.width = 0.05;
    bench.state.arms[0].gripper.grip_force = 20.0;
    bench.goal(7, [0.5, 0.3, 0.3], GripperGoal::Keep);
    bench.tick(true);
    assert_eq!(bench.command.gripper.width, 0.0);
    assert!(bench.command.gripper.force > 0.0);
}

/// An arm that something blocks: its drives follow the command, it does not.
#[test]
fn an_arm_that_is_blocked_stops_pressing_and_moves_when_it_is_free() {
    for selector in [RMPFLOW, LINE] {
        blocked(selector);
    }
}

fn blocked(selector: u32) {
    let mut bench = Bench::new();
    bench.goal(1, [0.5, 0.4, 0.3], GripperGoal::Open);
    bench.decision.goals[0].selector = selector;
    bench.tick(true);
    let blocked = bench.state.arms[0].joint_positions;
    let mut stopped = false;
    let error = |bench: &Bench| {
        let pairs = bench.command.joint_positions.iter().zip(&blocked);
        pairs.fold(0.0_f64, |worst, (c, b)| worst.max((c - b).abs()))
    };
    let (mut worst, mut least_after_stop) = (0.0_f64, f64::MAX);
    for _ in 0..4_000 {
        bench.run_within_limits(1, true);
        bench.state.arms[0].joint_positions = blocked;
        worst = worst.max(error(&bench));
        stopped |= bench.status.stop_cause == StopCause::TrackingError.code();
        if stopped {
            least_after_stop = least_after_stop.min(error(&bench));
        }
    }
    assert!(stopped && worst < 0.6, "{worst}");
    assert!(
        least_after_stop < 0.1,
        "it still presses: {least_after_stop}"
    );
    bench.run_within_limits(4_000, true);
    assert_eq!(bench.status.stop_action, StopAction::None.code());
    assert!((bench.status.setpoint.position[1] - 0.4).abs() < 0.01);
}
