//! One cycle of the robot.

use cell_model::ramp::{self, RampState};
use nalgebra::Isometry3;

use super::{Arm, LOST_ANSWERS, LateAnswer, Measured, Mode, Motion, Reflex, Setpoint};
use crate::datagram::RobotCommand;
use crate::error::Error;
use crate::follow::{follow, rest, start};
use crate::kinematics::Joints;
use crate::limits::{CYCLE_S, LINEAR, TOLERANCE};
use crate::motion::{Before, Broken, Generator, Tool, check_end, check_torques};
use crate::request::MoveStatus;

/// Distance at which parts of the arm count as touching (m).
const TOUCHING_M: f64 = 0.0;
/// Distances beyond this are not computed (m).
const REACH_M: f64 = 0.02;

/// Joints and end effector, and the joints at rest after a first command.
type Followed = (
    [RampState; super::JOINTS],
    Tool,
    Option<[RampState; super::JOINTS]>,
);

impl Arm {
    /// One cycle: takes the answer to the last state, if there is one, and gives the setpoint.
    /// In lockstep a missing answer is waited for, and this is not called without it.
    // A state is a millisecond of the robot, also where the caller missed one of physics: the
    // motion of a client would jump by two steps.
    pub fn advance(&mut self, measured: &Measured) -> Setpoint {
        let answer = self.memory.answer.take();
        if measured.is_held {
            // No rule was broken: the drives are held, or physics was restarted.
            self.end_move(MoveStatus::Aborted);
            self.memory.joints = measured.setpoint;
        }
        match self.memory.mode {
            Mode::Move(motion) => self.move_on(motion, answer.as_ref(), measured),
            Mode::Idle | Mode::Reflex => self.brake(),
        }
        self.serve_waiting();
        self.memory.message_id += 1;
        self.setpoint(measured)
    }

    /// The present state is sent again `count` times, under the next numbers: an answer to the
    /// last one is not used.
    pub fn repeat(&mut self, count: u32) {
        if count > 0 {
            self.memory.answer = None;
            self.memory.message_id += u64::from(count);
        }
    }

    fn move_on(&mut self, mut motion: Motion, answer: Option<&RobotCommand>, measured: &Measured) {
        // A client answers once it has seen the modes of its motion in a state.
        if answer.is_none() && !motion.is_running {
            self.memory.mode = Mode::Move(motion);
            return;
        }
        let is_first = !motion.is_running;
        motion.is_running = true;
        motion.cycles += 1;
        self.count(&mut motion, answer.is_some());
        self.memory.mode = Mode::Move(motion);
        let result = match answer {
            Some(command) => self.command(&motion, command, is_first, measured),
            None if motion.lost >= LOST_ANSWERS => Err(Broken {
                error: Error::COMMUNICATION,
                joint: None,
                value: f64::from(motion.lost),
                limit: f64::from(LOST_ANSWERS),
                unit: "answers in a row late or missing",
            }),
            None => self.extrapolate(&motion, measured),
        };
        let result = result.and_then(|()| self.check_measured(&motion, measured));
        match result {
            Err(broken) => self.stop(&motion, broken, measured),
            Ok(()) if answer.is_some_and(|command| command.is_finished) => {
                if motion.by_torque() {
                    self.memory.joints = measured.setpoint;
                }
                self.end_move(MoveStatus::Success);
            }
            Ok(()) => {}
        }
    }

    fn count(&mut self, motion: &mut Motion, is_answered: bool) {
        self.memory.answered = self.memory.answered << 1 | u128::from(is_answered);
        if is_answered {
            motion.lost = 0;
            return;
        }
        motion.lost += 1;
        self.memory.late.rotate_left(1);
        if let Some(newest) = self.memory.late.last_mut() {
            *newest = Some(LateAnswer {
                message_id: self.memory.message_id,
                after_cycles: None,
            });
        }
    }

    fn command(
        &mut self,
        motion: &Motion,
        command: &RobotCommand,
        is_first: bool,
        measured: &Measured,
    ) -> Result<(), Broken> {
        if motion.by_torque() {
            if !command.is_finished {
                check_torques(&self.limits, &self.memory.torques, &command.torques)?;
                self.memory.torques = command.torques;
            }
            self.follow_measured(motion, measured);
            return Ok(());
        }
        let (joints, tool, start) = self.followed(motion, command, is_first, measured)?;
        self.check_self(&joints)?;
        (self.memory.joints, self.memory.tool, self.memory.start) = (joints, tool, start);
        self.follow_by_joints(motion.generator);
        // A first command may be the start at rest, see `followed`.
        if command.is_finished && start.is_none() {
            let end_effector = self.end_effector();
            return check_end(
                &self.before(&end_effector, measured, false),
                motion.generator,
            );
        }
        Ok(())
    }

    fn before<'a>(
        &'a self,
        end_effector: &'a Isometry3<f64>,
        measured: &'a Measured,
        is_first: bool,
    ) -> Before<'a> {
        Before {
            limits: &self.limits,
            kinematics: &self.kinematics,
            end_effector,
            joints: &self.memory.joints,
            measured: &measured.positions,
            tool: &self.memory.tool,
            is_first,
        }
    }

    /// Joints and end effector after a command, and after the first one these at rest.
    // A first command is the next step of the motion, or its start at rest: only the second one
    // tells.
    fn followed(
        &self,
        motion: &Motion,
        command: &RobotCommand,
        is_first: bool,
        measured: &Measured,
    ) -> Result<Followed, Broken> {
        let end_effector = self.end_effector();
        let before = self.before(&end_effector, measured, is_first);
        let generator = motion.generator;
        let is_by_pose = matches!(
            generator,
            Generator::JointPosition | Generator::CartesianPose
        );
        let broken = match follow(&before, generator, command) {
            Ok((joints, tool)) => {
                let at_rest = joints.map(|joint| RampState {
                    position: joint.position,
                    ..RampState::default()
                });
                return Ok((joints, tool, (is_first && is_by_pose).then_some(at_rest)));
            }
            Err(broken) => broken,
        };
        let other = match &self.memory.start {
            _ if is_first => start(&before, generator, command),
            Some(joints) => {
                let tool = &rest(&before, joints);
                let before = Before {
                    joints,
                    tool,
                    ..before
                };
                follow(&before, generator, command).ok()
            }
            None => None,
        };
        other.map_or(Err(broken), |(joints, tool)| Ok((joints, tool, None)))
    }

    /// Continues with constant acceleration; torques are repeated.
    fn extrapolate(&mut self, motion: &Motion, measured: &Measured) -> Result<(), Broken> {
        if motion.by_torque() {
            self.follow_measured(motion, measured);
            return Ok(());
        }
        // As the robot: a client that continues its own profile after lost answers then has the
        // same discontinuity.
        let mut joints = self.memory.joints;
        for joint in &mut joints {
            joint.velocity += joint.acceleration * CYCLE_S;
            joint.position += joint.velocity * CYCLE_S;
        }
        for (joint, (next, limit)) in joints.iter().zip(&self.limits).enumerate() {
            if !limit.allows(next.position) {
                return Err(Broken {
                    error: Error::JOINT_POSITION,
                    joint: Some(joint),
                    value: next.position,
                    limit: limit.nearest_end(next.position),
                    unit: "rad",
                });
            }
        }
        self.memory.joints = joints;
        // A client in Cartesian space is judged from where the robot is by then.
        let pose = self.flange_at_joints() * self.end_effector();
        let last = self.memory.tool;
        self.memory.tool = Tool { pose, ..last };
        Ok(())
    }

    /// With torques the setpoint is where the joints are.
    fn follow_measured(&mut self, motion: &Motion, measured: &Measured) {
        for (joint, state) in self.memory.joints.iter_mut().enumerate() {
            *state = RampState {
                position: measured.positions[joint],
                velocity: measured.velocities[joint],
                acceleration: 0.0,
            };
        }
        self.follow_by_joints(motion.generator);
    }

    /// After a motion in joint space the commanded pose is that of the joints.
    fn follow_by_joints(&mut self, generator: Generator) {
        if !matches!(
            generator,
            Generator::CartesianPose | Generator::CartesianVelocity
        ) {
            self.memory.tool = Tool::at(self.flange_at_joints() * self.end_effector());
        }
    }

    fn flange_at_joints(&self) -> Isometry3<f64> {
        let positions = Joints::from_fn(|joint, _| self.memory.joints[joint].position);
        self.kinematics.flange(&positions)
    }

    pub(super) fn restart_tool(&mut self) {
        self.memory.tool = Tool::at(self.flange_at_joints() * self.end_effector());
    }

    /// Refuses setpoints with which two parts of the arm would touch.
    fn check_self(&mut self, joints: &[RampState]) -> Result<(), Broken> {
        for (&index, joint) in self.robot.arm_joints.iter().zip(joints) {
            if let Some(slot) = self.all_positions.get_mut(index) {
                *slot = joint.position;
            }
        }
        let (robot, positions) = (&self.robot, &self.all_positions);
        let distance = self.self_distance.nearest(robot, positions, REACH_M);
        if distance > TOUCHING_M {
            return Ok(());
        }
        Err(Broken {
            error: Error::SELF_COLLISION,
            joint: None,
            value: distance,
            limit: TOUCHING_M,
            unit: "m between two parts of the arm",
        })
    }

    fn check_measured(&self, motion: &Motion, measured: &Measured) -> Result<(), Broken> {
        if !motion.by_torque() {
            return Ok(());
        }
        for (joint, limit) in self.limits.iter().enumerate() {
            let (position, velocity) = (measured.positions[joint], measured.velocities[joint]);
            let (error, value, limit, unit) = if !limit.allows(position) {
                let end = limit.nearest_end(position);
                (Error::JOINT_POSITION, position, end, "rad")
            } else if velocity.abs() > limit.velocity_at(position, velocity) + TOLERANCE {
                let top = limit.velocity_at(position, velocity);
                (Error::JOINT_VELOCITY, velocity, top, "rad/s")
            } else {
                continue;
            };
            return Err(Broken {
                error,
                joint: Some(joint),
                value,
                limit,
                unit,
            });
        }
        self.check_measured_tool(measured)
    }

    fn check_measured_tool(&self, measured: &Measured) -> Result<(), Broken> {
        let positions = Joints::from(measured.positions);
        let (jacobian, _) = self.kinematics.jacobian(&positions, &self.end_effector());
        let twist = jacobian * Joints::from(measured.velocities);
        // Only the linear part: joint 7 alone may be faster than the limit of the angular one.
        let value = twist.fixed_rows::<3>(0).norm();
        let limit = LINEAR[0];
        if value <= limit * (1.0 + TOLERANCE) {
            return Ok(());
        }
        Err(Broken {
            error: Error::CARTESIAN_VELOCITY,
            joint: None,
            value,
            limit,
            unit: "m/s",
        })
    }

    fn stop(&mut self, motion: &Motion, broken: Broken, measured: &Measured) {
        if motion.by_torque() {
            self.memory.joints = measured.setpoint;
        }
        self.end_move(MoveStatus::Reflex);
        self.memory.mode = Mode::Reflex;
        self.memory.errors = broken.error.flags();
        self.memory.reflex_reason = self.memory.errors;
        self.memory.reflex = Some(Reflex {
            broken,
            cycle: motion.cycles,
            late: self.memory.late,
        });
    }

    /// Brakes within the limits, then holds.
    fn brake(&mut self) {
        ramp::brake_all(&mut self.memory.joints, &self.ramp_limits, CYCLE_S);
        if !self.is_at_rest() {
            self.restart_tool();
        }
    }

    fn setpoint(&mut self, measured: &Measured) -> Setpoint {
        let by_torque = matches!(self.memory.mode, Mode::Move(motion) if motion.is_running && motion.by_torque());
        let mut efforts = [0.0; super::JOINTS];
        if by_torque {
            let carried = self
                .dynamics
                .gravity_efforts(&measured.positions, &self.gravity);
            for (effort, (carried, torque)) in efforts
                .iter_mut()
                .zip(carried.iter().zip(&self.memory.torques))
            {
                *effort = carried + torque;
            }
        } else {
            let of = |value: fn(&RampState) -> f64| self.memory.joints.map(|joint| value(&joint));
            let (positions, velocities) = (of(|j| j.position), of(|j| j.velocity));
            let accelerations = of(|j| j.acceleration);
            let fed = self.dynamics.inverse_dynamics(
                &positions,
                &velocities,
                &accelerations,
                &self.gravity,
            );
            for (effort, fed) in efforts.iter_mut().zip(fed) {
                *effort = *fed;
            }
        }
        for (external, (measured, effort)) in self
            .memory
            .external
            .iter_mut()
            .zip(measured.torques.iter().zip(&efforts))
        {
            // A low pass of 10 Hz.
            *external += 0.06 * (effort - measured - *external);
        }
        Setpoint {
            joints: self.memory.joints,
            efforts,
            by_torque,
        }
    }
}
