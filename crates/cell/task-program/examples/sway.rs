//! A custom controller beside RMPflow: it sways one joint, which it finds by
//! name; then the built-in joint-space PD moves the arm home.

use std::f64::consts::TAU;
use std::process::ExitCode;

use robocell_task::{
    ArmIntent, GoalKind, Job, Observation, Outcome, Output, Policies, Policy, Pose,
};
use robocell_task_program::control::Controllers;
use robocell_task_program::control::controller::{Controller, Setpoint};
use robocell_task_program::control::controllers::{ArmContext, JOINT_PD};
use robocell_task_program::control::robot_state::RobotState;

/// Number of the controller.
const SWAY: u32 = 7;

struct Sway {
    joint: usize,
    /// Initial position of the joint (rad), and the time it has swayed (s).
    memory: [f64; 2],
}

impl Controller for Sway {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        // The estimate at the switch is the start of the motion: another value would be a jump.
        self.memory = [estimated.positions.get(self.joint).unwrap_or(0.0), 0.0];
        true
    }

    /// The joint positions wanted; the limiter after it enforces the robot's limits.
    fn forward(&mut self, _: &RobotState, _: &Setpoint) -> Option<RobotState> {
        let [start, time] = &mut self.memory;
        // One cycle is 1 ms in every mode of time (ADR 0003).
        *time += 0.001;
        let mut wanted = RobotState::EMPTY;
        let angle = *start + 0.2 * (0.5 * TAU * *time).sin();
        wanted.positions.set(self.joint, angle);
        Some(wanted)
    }

    fn memory(&mut self) -> &mut [f64] {
        // In the checkpoint of the controller, which resumes the sine where it was killed.
        &mut self.memory
    }
}

struct ThereAndBack;

impl Policy for ThereAndBack {
    type Memory = ();

    fn decide(&self, (): &mut (), cell: &Observation<'_>, _: &mut Job, out: &mut Output) {
        let sways = cell.time().seconds() < 4.0;
        let mut posture = [0.0; ipc_types::MAX_JOINTS];
        posture[..7].copy_from_slice(&[0.012, -0.5686, 0.0, -2.8102, 0.0, 3.0366, 0.741]);
        let intent = ArmIntent {
            kind: GoalKind::Joints,
            // Another key is a new goal: the controller is switched by a goal, not during one.
            key: u64::from(sways),
            selector: if sways { SWAY } else { JOINT_PD },
            posture: Some(posture),
            target: Pose::IDENTITY,
            ..ArmIntent::default()
        };
        out.arm(0, intent);
        if cell.time().seconds() > 7.0 {
            out.outcome = Outcome::Done;
        }
    }
}

fn main() -> ExitCode {
    let controllers = Controllers::default().with(SWAY, "sway", |context: &ArmContext<'_>| {
        let joint = context.joints.index("panda_joint1").unwrap_or(0);
        Ok(Box::new(Sway {
            joint,
            memory: [0.0; 2],
        }))
    });
    let policies = Policies::new().policy("sway", |_| ThereAndBack);
    robocell_task_program::main_with(policies, controllers, Vec::new())
}
