//! From an accepted command to the drives of an arm and its hand.

use cell_model::cells::cell::Disturbance;
use cell_model::ramp::RampState;
use cell_model::{ArmSpec, Dynamics};
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

/// What drives one arm.
pub(crate) struct ArmDrive {
    /// What the drives were told in the last tick, by joint of the chain.
    pub(crate) targets: Vec<DriveTarget>,
    limits: JointLimits,
    dynamics: Dynamics,
    delay: Delay,
    /// Gravity in the base frame (m/s²).
    gravity: Vector3<f64>,
}

impl ArmDrive {
    /// Of an arm that is in the engine.
    pub(crate) fn new(spec: &ArmSpec, disturbance: &Disturbance) -> Self {
        Self {
            delay: Delay::new(disturbance.drive_delay_s),
            targets: vec![DriveTarget::default(); spec.robot.joints.len()],
            limits: spec.robot.limits(),
            dynamics: Dynamics::new(&spec.robot),
            gravity: spec.base.rotation.inverse() * Vector3::from(GRAVITY),
        }
    }

    /// The joints follow `command`, or what the watchdog does without one.
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
        if let (true, Some(command)) = (output.accepted, command) {
            memory.suction.command(&command.gripper);
            if let Some(gripper) = &robot.gripper {
                memory.gripper.command(&command.gripper, gripper);
            }
        }
        if has_no_power(output.stop.action, &memory.watchdog) {
            self.brake(engine, (arm, measured), memory);
            return;
        }
        memory.brakes.release();
        let positions = robot.arm_joints.iter();
        let positions: Vec<f64> = positions.map(|&joint| measured.positions[joint]).collect();
        let carried = self
            .dynamics
            .inverse_dynamics(&positions, &[], &[], &self.gravity)
            .to_vec();
        let setpoint: Vec<_> = memory.watchdog.setpoint().collect();
        let efforts = if output.own {
            let of =
                |value: fn(&RampState) -> f64| setpoint.iter().map(value).collect::<Vec<f64>>();
            self.dynamics.inverse_dynamics(
                &of(|s| s.position),
                &of(|s| s.velocity),
                &of(|s| s.acceleration),
                &self.gravity,
            )
        } else {
            memory.watchdog.efforts()
        };
        let efforts = efforts.iter().zip(&carried);
        let states = setpoint.iter().zip(efforts);
        let joints = robot.arm_joints.iter().zip(states);
        let targets = joints.map(|(&joint, (state, (effort, gravity)))| DriveTarget {
            position: state.position,
            velocity: state.velocity,
            effort: *effort,
            gravity: *gravity,
            max_effort: robot.joints[joint].effort,
        });
        let targets = self.delay.pass(&mut memory.delayed, targets.collect());
        for (&joint, target) in robot.arm_joints.iter().zip(targets) {
            arm.drive(engine, joint, &target);
            self.targets[joint] = target;
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
        memory.delayed.clear();
        let held = memory.brakes.hold(robot, &measured.positions);
        for (&joint, target) in robot.arm_joints.iter().zip(held) {
            arm.drive(engine, joint, &target);
            // The drive itself gives nothing, which is what the state tells.
            self.targets[joint] = DriveTarget {
                max_effort: 0.0,
                ..target
            };
        }
        let at = robot.arm_joints.iter();
        let at = at.map(|&joint| measured.positions[joint]);
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
        let finger = 0.5 * (measured.positions[left] + measured.positions[right]);
        let stiffness = arm.robot.joints[left].stiffness;
        let target = memory.gripper.step(gripper, stiffness, finger);
        for joint in gripper.finger_joints {
            arm.drive(engine, joint, &target);
            self.targets[joint] = target;
        }
    }
}

/// Category 0: at once. Category 1: when the ramp has ended.
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
