//! From an accepted command to the drives of an arm and its hand.

use cell_model::cells::cell::Disturbance;
use cell_model::ramp::RampState;
use cell_model::{ArmSpec, Dynamics, Robot};
use ipc_types::arm::StopAction;
use ipc_types::{ArmCommand, Input};
use nalgebra::Vector3;
use rapier3d_f64::prelude::PhysicsWorld;
use rmp::JointLimits;

use crate::arm::delay::Delay;
use crate::arm::measured::Measured;
use crate::arm::memory::ArmMemory;
use crate::arm::multibody::{Arm, DriveTarget};
use crate::arm::watchdog::Watchdog;
use crate::engine::settings::GRAVITY;

/// The drives of one arm.
pub(crate) struct ArmDrive {
    /// Targets of the drives in the last tick, by joint of the chain.
    pub(crate) targets: Vec<DriveTarget>,
    limits: JointLimits,
    dynamics: Dynamics,
    delay: Delay,
    /// Gravity in the base frame (m/s²).
    gravity: Vector3<f64>,
    /// Room for the targets of a tick by controlled joint, and for numbers of the joints.
    wanted: Vec<DriveTarget>,
    numbers: Vec<f64>,
}

impl ArmDrive {
    /// The drives of an arm that is in the engine.
    pub(crate) fn new(spec: &ArmSpec, disturbance: &Disturbance) -> Self {
        Self {
            delay: Delay::new(disturbance.drive_delay_s),
            targets: vec![DriveTarget::default(); spec.robot.joints.len()],
            limits: spec.robot.limits(),
            dynamics: Dynamics::new(&spec.robot),
            gravity: spec.base.rotation.inverse() * Vector3::from(GRAVITY),
            wanted: Vec::with_capacity(spec.robot.arm_joints.len()),
            numbers: Vec::with_capacity(3 * spec.robot.arm_joints.len()),
        }
    }

    /// Moves the joints by `command`, or as the watchdog decides without one.
    pub(crate) fn joints(
        &mut self,
        engine: &mut PhysicsWorld,
        (arm, measured): (&Arm, &Measured),
        memory: &mut ArmMemory,
        (tick, command): (u64, Option<&ArmCommand>),
    ) {
        let robot = &arm.robot;
        let output = memory.watchdog.update(tick, command, robot, &self.limits);
        memory.stop_action = output.stop.action.code();
        // The hand follows accepted commands only; on silence it keeps its last command, so
        // that a held object is not dropped.
        if let (true, Some(command)) = (output.accepted, command) {
            memory.suction.command(&command.gripper);
            if let Some(gripper) = &robot.gripper {
                memory.gripper.command(&command.gripper, gripper);
            }
        }
        // After the watchdog: a stop of this tick has its effect in this tick.
        if has_no_power(output.stop.action, &memory.watchdog) {
            self.brake(engine, (arm, measured), memory);
            return;
        }
        // The next loss of power holds where the arm is then, not where it was held before.
        memory.brakes.release();
        let setpoints = memory.watchdog.setpoint().zip(memory.watchdog.efforts());
        let joints = robot.arm_joints.iter().zip(setpoints);
        self.wanted.clear();
        let wanted = joints.map(|(&joint, (state, effort))| DriveTarget {
            position: state.position,
            velocity: state.velocity,
            effort: *effort,
            gravity: 0.0,
            max_effort: robot.joints[joint].effort,
        });
        self.wanted.extend(wanted);
        // Without feed-forward the arm sags when the controller dies (ADR 0006).
        if output.own {
            self.feed_forward(&memory.watchdog);
        }
        // Carried at the measured positions, as a load is: the setpoint may be elsewhere when
        // the arm is blocked.
        self.carry(robot, measured);
        self.delay.pass(&mut memory.delayed, &mut self.wanted);
        for (&joint, target) in robot.arm_joints.iter().zip(&self.wanted) {
            arm.drive(engine, joint, target);
            self.targets[joint] = *target;
        }
    }

    /// Efforts for a setpoint that was computed here, not commanded.
    fn feed_forward(&mut self, watchdog: &Watchdog) {
        let numbers = &mut self.numbers;
        let of = |value: fn(&RampState) -> f64, numbers: &mut Vec<f64>| {
            numbers.extend(watchdog.setpoint().map(|state| value(&state)));
        };
        numbers.clear();
        of(|state| state.position, numbers);
        of(|state| state.velocity, numbers);
        of(|state| state.acceleration, numbers);
        let (positions, rates) = numbers.split_at(self.wanted.len());
        let (velocities, accelerations) = rates.split_at(self.wanted.len());
        let dynamics = &mut self.dynamics;
        let efforts =
            dynamics.inverse_dynamics(positions, velocities, accelerations, &self.gravity);
        for (target, effort) in self.wanted.iter_mut().zip(efforts) {
            target.effort = *effort;
        }
    }

    /// Efforts that carry the arm at its measured positions.
    fn carry(&mut self, robot: &Robot, measured: &Measured) {
        let positions = robot.arm_joints.iter();
        let positions = positions.map(|&joint| measured.positions[joint]);
        self.numbers.clear();
        self.numbers.extend(positions);
        let carried = self.dynamics.gravity_efforts(&self.numbers, &self.gravity);
        for (target, gravity) in self.wanted.iter_mut().zip(carried) {
            target.gravity = *gravity;
        }
    }

    /// The brakes hold the joints.
    fn brake(
        &mut self,
        engine: &mut PhysicsWorld,
        (arm, measured): (&Arm, &Measured),
        memory: &mut ArmMemory,
    ) {
        let robot = &arm.robot;
        // Delayed targets are from before the stop; they must not move the arm when power
        // returns.
        memory.delayed.clear();
        let held = memory.brakes.hold(robot, &measured.positions);
        for (&joint, target) in robot.arm_joints.iter().zip(held) {
            arm.drive(engine, joint, &target);
            // The drive gives no effort, which is what the state reports.
            self.targets[joint] = DriveTarget {
                max_effort: 0.0,
                ..target
            };
        }
        let at = robot.arm_joints.iter();
        let at = at.map(|&joint| measured.positions[joint]);
        // The next controller starts where the brakes hold the arm (ADR 0007).
        memory.watchdog.rest_at(at);
    }

    /// The fingers follow the last accepted command.
    pub(crate) fn fingers(
        &mut self,
        engine: &mut PhysicsWorld,
        (arm, measured): (&Arm, &Measured),
        memory: &mut ArmMemory,
    ) {
        let Some(gripper) = &arm.robot.gripper else {
            return;
        };
        let [left, right] = gripper.finger_joints;
        // The mean of both fingers: they are coupled, and a target for one alone would pull at
        // the coupling.
        let finger = 0.5 * (measured.positions[left] + measured.positions[right]);
        let stiffness = arm.robot.joints[left].stiffness;
        let target = memory.gripper.step(gripper, stiffness, finger);
        for joint in gripper.finger_joints {
            arm.drive(engine, joint, &target);
            self.targets[joint] = target;
        }
    }
}

/// Stop category 0 removes power at once, category 1 when the ramp has ended.
fn has_no_power(action: StopAction, watchdog: &Watchdog) -> bool {
    match action {
        StopAction::Stop0 => true,
        StopAction::Stop1 => watchdog.setpoint().all(|setpoint| setpoint.stands()),
        _ => false,
    }
}

/// The accepted command of arm `index`, as an input of the state.
pub(crate) fn input(index: usize, memory: &ArmMemory, tick: u64) -> Option<Input> {
    let accepted = memory.watchdog.accepted()?;
    let arm = u8::try_from(index).unwrap_or(u8::MAX);
    Some(Input {
        topic: ipc_types::topic::TopicId::ArmCommand(arm).code(),
        generation: accepted.generation,
        seq: accepted.seq,
        age_ticks: tick.saturating_sub(accepted.tick),
    })
}
