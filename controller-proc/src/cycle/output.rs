//! The output of a cycle: the command to the drives, and the status.

use cell_model::robots::dynamics::GRAVITY;
use cell_model::stop::Stop;
use ipc_types::arm::PATH_POINTS;
use ipc_types::decision::GoalKind;
use ipc_types::{
    ArmCommand, ArmState, ArmStatus, GripperCommand, GripperGoal, Header, Input, MAX_JOINTS, Pose,
    Text, WorldState,
};
use nalgebra::Vector3;

use super::Cycle;
use crate::convert::{angle, isometry, pose};

impl Cycle {
    fn inputs(&self, state: &WorldState, header: &mut Header) {
        header.push_input(Input {
            topic: ipc_types::topic::TopicId::WorldState.code(),
            generation: state.header.generation,
            seq: state.header.seq,
            age_ticks: 0,
        });
        if let Some(tick) = self.latch.decision_tick() {
            header.push_input(Input {
                topic: ipc_types::topic::TopicId::Decision.code(),
                generation: self.latch.generation(),
                seq: self.latch.seq(),
                age_ticks: state.header.tick.saturating_sub(tick),
            });
        }
    }

    pub(super) fn write_command(&mut self, state: &WorldState, command: &mut ArmCommand) {
        command.header = Header::caused_by::<ArmCommand>(state.header.tick);
        self.inputs(state, &mut command.header);
        command.arm = u32::try_from(self.arm).unwrap_or(u32::MAX);
        command.joint_count = u32::try_from(self.joint_count).unwrap_or(u32::MAX);
        let n = self.joint_count.min(MAX_JOINTS);
        let (q, qd, qdd) = (
            self.last.positions.first(n),
            self.last.velocities.first(n),
            self.last.accelerations.first(n),
        );
        command.joint_positions[..n].copy_from_slice(q);
        command.joint_velocities[..n].copy_from_slice(qd);
        command.joint_accelerations[..n].copy_from_slice(qdd);
        // Feed-forward of the commanded motion, gravity included: without it the arm sags, as
        // on a real robot (ADR 0006).
        let gravity = self.base.rotation.inverse() * Vector3::from(GRAVITY);
        let efforts = self.dynamics.inverse_dynamics(q, qd, qdd, &gravity);
        for (slot, effort) in command.joint_efforts.iter_mut().zip(efforts) {
            *slot = *effort;
        }
        command.gripper = self.gripper_command();
    }

    fn gripper_command(&self) -> GripperCommand {
        let fingers = [self.joint_count, self.joint_count + 1];
        let width = fingers
            .iter()
            .filter_map(|j| self.last.positions.get(*j))
            .fold(0.0, |sum, position| sum + position);
        // A force of zero in the goal is the gripper's default.
        let asked = self.latch.goal().grip_force;
        let force = self.gripper.as_ref().map_or(0.0, |g| {
            let wanted = if asked > 0.0 { asked } else { g.default_force };
            wanted.min(g.max_force)
        });
        GripperCommand {
            width,
            force,
            suction: self.suction.code(),
            reserved: 0,
        }
    }

    pub(super) fn write_status(
        &self,
        state: &WorldState,
        arm: &ArmState,
        stop: Stop,
        status: &mut ArmStatus,
    ) {
        let goal = self.latch.goal();
        let tcp = isometry(&arm.tcp);
        let target = isometry(&goal.target);
        // The command in force, not the goal: the task grades the width against it.
        let gripper = self.gripper_command();
        status.header = Header::caused_by::<ArmStatus>(state.header.tick);
        self.inputs(state, &mut status.header);
        status.arm = u32::try_from(self.arm).unwrap_or(u32::MAX);
        status.stop_action = stop.action.code();
        status.stop_cause = stop.cause.code();
        status.goal_active = u32::from(self.latch.kind() != GoalKind::Hold && !stop.stops_motion());
        status.goal_generation = self.latch.generation();
        status.selector = goal.selector;
        status.goal_id = goal.goal_id;
        status.decision_tick = self.latch.decision_tick().unwrap_or(0);
        status.decision_age_ticks = state.header.tick.saturating_sub(status.decision_tick);
        // From the measured pose: the task has to know where the tool is, not where it should
        // be.
        status.position_error = (tcp.translation.vector - target.translation.vector).norm();
        status.orientation_error = angle(&tcp.rotation, &target.rotation);
        status.gripper_error = match self.gripper {
            Some(_) => arm.gripper.width - gripper.width,
            None => 0.0,
        };
        status.setpoint = pose(&(self.base * self.controllers.arm.tool_pose()));
        // The identity before the first goal keeps the message valid.
        status.target = if goal.goal_id == 0 {
            Pose::IDENTITY
        } else {
            goal.target
        };
        let motion = &self.controllers.arm;
        status.min_clearance = motion.min_clearance();
        status.clipped_joints = motion.clipped_joints();
        status.clipped_cycles = self.clipped_cycles;
        status.cycles = self.cycles;
        status.missed_cycles = self.missed_cycles;
        let report = motion.plan_report();
        status.plan_state = report.state.code();
        status.not_reached = report.not_reached.code();
        status.answered_plan = report.answered;
        (status.path_at, status.path_length, status.path) =
            report.path.unwrap_or((0.0, 0.0, [[0.0; 3]; PATH_POINTS]));
        status.gripper = gripper;
        status.controller = Text::new(self.controller_name());
    }

    /// Name of the selected controller, or of the combination of RMPflow and gripper.
    fn controller_name(&self) -> &'static str {
        let by_rmpflow = match self.latch.gripper() {
            GripperGoal::Keep => "move, keep",
            GripperGoal::Open => "move, open",
            GripperGoal::Close => "move, close",
        };
        let selected = self.controllers.arm.active_name();
        selected.unwrap_or(by_rmpflow)
    }
}
