//! Joints as measured.

use cell_model::Robot;
use cell_model::ramp::RampState;
use ipc_types::validate::{MAX_JOINT_POSITION, MAX_JOINT_VELOCITY};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::PhysicsWorld;

use crate::arm::multibody::Arm;
use crate::engine::convert;
use crate::engine::simulation::Engine;

/// Joints of one arm, by joint of the chain. Always finite and plausible: a state the
/// engine lost keeps its last good values.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// rad or m.
    pub(super) positions: Vec<f64>,
    /// rad/s or m/s.
    pub(super) velocities: Vec<f64>,
    scratch: (Vec<f64>, Vec<f64>),
}

impl Measured {
    /// At home.
    pub(crate) fn new(robot: &Robot) -> Self {
        let home: Vec<f64> = robot.joints.iter().map(|spec| spec.home).collect();
        let zeros = vec![0.0; home.len()];
        Self {
            positions: home,
            velocities: zeros.clone(),
            scratch: (zeros.clone(), zeros),
        }
    }

    /// Positions (rad or m).
    pub(crate) fn positions(&self) -> &[f64] {
        &self.positions
    }

    /// Velocities (rad/s or m/s).
    pub(crate) fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// Takes the setpoints of the controlled joints as measured.
    pub(crate) fn follow(&mut self, robot: &Robot, setpoints: impl Iterator<Item = RampState>) {
        for (&joint, setpoint) in robot.arm_joints.iter().zip(setpoints) {
            self.positions[joint] = setpoint.position;
            self.velocities[joint] = setpoint.velocity;
        }
    }

    /// Reads the joints from the engine; `false` if they are not plausible, which keeps the
    /// last values.
    pub(crate) fn read(&mut self, arm: &Arm, world: &PhysicsWorld) -> bool {
        let (positions, velocities) = &mut self.scratch;
        arm.measure(world, positions, velocities);
        // The limits of the message: an engine that diverges reaches them before its numbers
        // are not finite, and readers would refuse such a state.
        let is_good = positions.iter().all(|x| x.abs() <= MAX_JOINT_POSITION)
            && velocities.iter().all(|x| x.abs() <= MAX_JOINT_VELOCITY);
        if is_good {
            self.positions.copy_from_slice(positions);
            self.velocities.copy_from_slice(velocities);
        }
        is_good
    }
}

/// The TCP in the world frame: from the engine, or from the joints if the engine has no finite
/// pose, or does not move them.
pub(crate) fn finite_tcp(engine: &Engine, arm: &Arm, measured: &Measured) -> Isometry3<f64> {
    let (is_ideal, engine) = (engine.is_ideal(), engine.rapier());
    let tcp = arm.tcp(engine);
    if !is_ideal
        && tcp
            .translation
            .vector
            .iter()
            .chain(tcp.rotation.coords.iter())
            .all(|x| x.is_finite())
    {
        return tcp;
    }
    let base = arm.bodies.first().and_then(|base| engine.bodies.get(*base));
    let base = base.map_or_else(Isometry3::identity, |base| {
        convert::from_pose(base.position())
    });
    base * arm
        .robot
        .frame_pose(arm.robot.tcp_frame, &measured.positions)
        .unwrap_or_default()
}
