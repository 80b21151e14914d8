//! The state of the robot as a datagram (libfranka-common,
//! `research_interface/robot/rbk_types.h`, version 10).

use nalgebra::{Isometry3, Matrix4, Vector6};

use crate::JOINTS;
use crate::bytes::Writer;
use crate::datagram::Elbow;
use crate::error::Errors;
use crate::hand::Hand;
use crate::motion::Tool;

/// Bytes of a state.
pub const STATE_BYTES: usize = 1377;

/// Values of a state; those that it lacks are sent as zeros.
pub(crate) struct StateValues<'a> {
    pub(crate) message_id: u64,
    /// End effector as measured, in the base frame.
    pub(crate) measured_pose: Isometry3<f64>,
    pub(crate) commanded: &'a Tool,
    /// End effector in the flange frame, and its parts.
    pub(crate) end_effector: Isometry3<f64>,
    pub(crate) nominal: Isometry3<f64>,
    pub(crate) nominal_to_end: Isometry3<f64>,
    pub(crate) stiffness_frame: [f64; 16],
    pub(crate) hand: &'a Hand,
    pub(crate) load: (f64, [f64; 3], [f64; 9]),
    pub(crate) positions: [f64; JOINTS],
    pub(crate) velocities: [f64; JOINTS],
    pub(crate) torques: [f64; JOINTS],
    pub(crate) commanded_torques: [f64; JOINTS],
    pub(crate) commanded_positions: [f64; JOINTS],
    pub(crate) commanded_velocities: [f64; JOINTS],
    pub(crate) commanded_accelerations: [f64; JOINTS],
    pub(crate) external_torques: [f64; JOINTS],
    pub(crate) external_wrench: Vector6<f64>,
    pub(crate) generator_mode: u8,
    pub(crate) controller_mode: u8,
    pub(crate) errors: Errors,
    pub(crate) reflex_reason: Errors,
    pub(crate) robot_mode: u8,
    pub(crate) success_rate: f64,
}

/// A pose as the 16 numbers of its matrix, column by column.
pub(crate) fn columns(pose: &Isometry3<f64>) -> [f64; 16] {
    let matrix: Matrix4<f64> = pose.to_homogeneous();
    std::array::from_fn(|index| matrix[(index % 4, index / 4)])
}

impl StateValues<'_> {
    /// Writes the datagram.
    pub(crate) fn write(&self, out: &mut [u8; STATE_BYTES]) {
        let mut to = Writer::new(out);
        to.bytes(&self.message_id.to_le_bytes());
        to.f32s(&columns(&self.measured_pose));
        to.f32s(&columns(&self.commanded.pose));
        to.f32s(&columns(&self.end_effector));
        to.f32s(&self.stiffness_frame);
        to.f32s(&columns(&self.nominal));
        to.f32s(&columns(&self.nominal_to_end));
        to.f32s(&[self.hand.mass]);
        to.f32s(&self.hand.inertia);
        to.f32s(&self.hand.center);
        let (mass, center, inertia) = &self.load;
        to.f32s(&[*mass]);
        to.f32s(inertia);
        to.f32s(center);
        // Measured and commanded.
        to.f32s(&elbow(&self.positions));
        to.f32s(&elbow(&self.commanded_positions));
        to.f32s(&self.torques);
        to.f32s(&self.commanded_torques);
        to.zeros(JOINTS);
        to.f32s(&self.positions);
        to.f32s(&self.commanded_positions);
        to.f32s(&self.velocities);
        to.f32s(&self.commanded_velocities);
        to.f32s(&self.commanded_accelerations);
        // Contacts and collisions of joints and end effector.
        to.zeros(26);
        to.f32s(&self.external_torques);
        to.f32s(self.external_wrench.as_slice());
        to.f32s(self.external_wrench.as_slice());
        to.f32s(self.commanded.twist.as_slice());
        // The acceleration of the base, which is this constant at the robot, too (`robot_state.h`).
        to.f32s(&[0.0, 0.0, -9.81]);
        to.f32s(&elbow(&self.commanded_positions));
        to.zeros(4);
        to.f32s(&columns(&self.commanded.pose));
        to.f32s(self.commanded.twist.as_slice());
        to.f32s(self.commanded.acceleration.as_slice());
        // The motors: the joints are rigid here.
        to.f32s(&self.positions);
        to.f32s(&self.velocities);
        // Accelerometers.
        to.zeros(36);
        to.bytes(&[self.generator_mode, self.controller_mode]);
        to.bytes(&self.errors.bytes());
        to.bytes(&self.reflex_reason.bytes());
        to.bytes(&[self.robot_mode]);
        to.f32s(&[self.success_rate]);
        debug_assert_eq!(to.len(), STATE_BYTES);
    }
}

fn elbow(positions: &[f64; JOINTS]) -> [f64; 2] {
    let Elbow { position, sign } = Elbow::of(positions);
    [position, sign]
}
