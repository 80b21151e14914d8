//! From an accepted command to the drives of the joints of an arm.

use cell_model::cells::cell::Disturbance;
use cell_model::ramp::RampState;
use cell_model::{ArmSpec, Dynamics, Robot};
use ipc_types::arm::StopAction;
use ipc_types::{ArmCommand, ArmState, Input};
use nalgebra::Vector3;
use rapier3d_f64::prelude::PhysicsWorld;
use rmp::JointLimits;
use serde::{Deserialize, Serialize};

use crate::arm::brake::Brakes;
use crate::arm::delay::{Delay, Delayed};
use crate::arm::measured::Measured;
use crate::arm::multibody::{Arm, DriveTarget};
use crate::arm::watchdog::Watchdog;
use crate::engine::settings::GRAVITY;

/// The drives of one arm.
pub(crate) struct ArmDrive {
    /// Targets of the drives in the last tick, by joint of the chain.
    targets: Vec<DriveTarget>,
    limits: JointLimits,
    dynamics: Dynamics,
    delay: Delay,
    /// Gravity in the base frame (m/s²).
    gravity: Vector3<f64>,
    /// Room for the targets of a tick by controlled joint, and for numbers of the joints.
    wanted: Vec<DriveTarget>,
    numbers: Vec<f64>,
    state: DriveState,
    /// Code of the [`StopAction`] of the last tick, which is reported.
    stop_action: u32,
}

/// State that decides the next tick: part of every snapshot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DriveState {
    watchdog: Watchdog,
    brakes: Brakes,
    delayed: Delayed,
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
            state: DriveState {
                watchdog: Watchdog::new(&spec.home),
                brakes: Brakes::default(),
                delayed: Delayed::default(),
            },
            stop_action: 0,
        }
    }

    /// The watchdog of the arm.
    pub(crate) fn watchdog(&self) -> &Watchdog {
        &self.state.watchdog
    }

    /// The watchdog of the arm, to report faults and counts to it.
    pub(crate) fn watchdog_mut(&mut self) -> &mut Watchdog {
        &mut self.state.watchdog
    }

    /// The state as part of a snapshot, and the code of the [`StopAction`] that is reported.
    pub(crate) fn save(&self) -> (&DriveState, u32) {
        (&self.state, self.stop_action)
    }

    /// Continues from a snapshot.
    pub(crate) fn restore(&mut self, state: DriveState, stop_action: u32) {
        (self.state, self.stop_action) = (state, stop_action);
    }

    /// Back to the state at the start; the counts of the watchdog continue.
    pub(crate) fn reset(&mut self, mut initial: DriveState, stop_action: u32, tick: u64) {
        initial.watchdog.carry_over(&self.state.watchdog, tick);
        self.restore(initial, stop_action);
    }

    /// Moves the joints by `command`, or as the watchdog decides without one; `true` if the
    /// command was accepted.
    pub(crate) fn before_step(
        &mut self,
        engine: &mut PhysicsWorld,
        (arm, measured): (&Arm, &Measured),
        (tick, command): (u64, Option<&ArmCommand>),
    ) -> bool {
        let robot = &arm.robot;
        let state = &mut self.state;
        let output = state.watchdog.update(tick, command, robot, &self.limits);
        self.stop_action = output.stop.action.code();
        // After the watchdog: a stop of this tick has its effect in this tick.
        if has_no_power(output.stop.action, &state.watchdog) {
            self.brake(engine, (arm, measured));
            return output.accepted;
        }
        // The next loss of power holds where the arm is then, not where it was held before.
        state.brakes.release();
        let setpoints = state.watchdog.setpoint().zip(state.watchdog.efforts());
        let joints = robot.arm_joints.iter().zip(setpoints);
        self.wanted.clear();
        let by_effort = state.watchdog.is_by_effort();
        let wanted = joints.map(|(&joint, (state, effort))| DriveTarget {
            position: state.position,
            velocity: state.velocity,
            effort: *effort,
            gravity: 0.0,
            max_effort: robot.joints[joint].effort,
            by_effort,
        });
        self.wanted.extend(wanted);
        // Without feed-forward the arm sags when the controller dies (ADR 0006).
        if output.own {
            self.feed_forward();
        }
        // Carried at the measured positions, as a load is: the setpoint may be elsewhere when
        // the arm is blocked.
        self.carry(robot, measured);
        self.delay.pass(&mut self.state.delayed, &mut self.wanted);
        for (&joint, target) in robot.arm_joints.iter().zip(&self.wanted) {
            arm.drive(engine, joint, target);
            self.targets[joint] = *target;
        }
        output.accepted
    }

    /// Efforts for a setpoint that was computed here, not commanded.
    fn feed_forward(&mut self) {
        let (watchdog, numbers) = (&self.state.watchdog, &mut self.numbers);
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
    fn brake(&mut self, engine: &mut PhysicsWorld, (arm, measured): (&Arm, &Measured)) {
        let (robot, state) = (&arm.robot, &mut self.state);
        // Delayed targets are from before the stop; they must not move the arm when power
        // returns.
        state.delayed.clear();
        let held = state.brakes.hold(robot, &measured.positions);
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
        state.watchdog.rest_at(at);
    }

    /// Writes the drives and the watchdog to the report of the arm.
    pub(crate) fn write(&self, arm: &Arm, measured: &Measured, out: &mut ArmState) {
        let watchdog = &self.state.watchdog;
        out.stop_action = self.stop_action;
        let joints = arm.robot.arm_joints.iter().zip(watchdog.setpoint());
        for (index, (&joint, setpoint)) in joints.enumerate() {
            let (position, velocity) = (measured.positions[joint], measured.velocities[joint]);
            out.joint_positions[index] = position;
            out.joint_velocities[index] = velocity;
            // Computed by the law of the drive: the engine solves it within the tick and does
            // not report it.
            out.joint_efforts[index] = arm.effort(joint, &self.targets[joint], position, velocity);
            out.setpoint_positions[index] = setpoint.position;
            out.setpoint_velocities[index] = setpoint.velocity;
            out.setpoint_accelerations[index] = setpoint.acceleration;
            out.joint_count += 1;
        }
        if let Some(accepted) = watchdog.accepted() {
            out.command_seq = accepted.seq;
            out.command_tick = accepted.tick;
            out.command_generation = accepted.generation;
        }
        out.fault = u32::from(watchdog.fault);
        out.limit_violations = watchdog.violations;
    }

    /// The accepted command of arm `index`, as an input of the state.
    pub(crate) fn input(&self, index: usize, tick: u64) -> Option<Input> {
        let accepted = self.state.watchdog.accepted()?;
        let arm = u8::try_from(index).unwrap_or(u8::MAX);
        Some(Input {
            topic: ipc_types::topic::TopicId::ArmCommand(arm).code(),
            generation: accepted.generation,
            seq: accepted.seq,
            age_ticks: tick.saturating_sub(accepted.tick),
        })
    }
}

/// Stop category 0 removes power at once, category 1 when the ramp has ended.
fn has_no_power(action: StopAction, watchdog: &Watchdog) -> bool {
    match action {
        StopAction::Stop0 => true,
        StopAction::Stop1 => watchdog.setpoint().all(|setpoint| setpoint.is_at_rest()),
        _ => false,
    }
}
