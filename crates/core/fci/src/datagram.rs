//! The command of a client for one cycle, over UDP (libfranka-common,
//! `research_interface/robot/rbk_types.h`, version 10).

use serde::{Deserialize, Serialize};

use crate::JOINTS;
use crate::bytes::Reader;

/// Bytes of a command.
pub const COMMAND_BYTES: usize = 371;

/// A command. Values that the motion does not use may be anything.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotCommand {
    /// Number of the state that it answers.
    pub message_id: u64,
    /// Joint positions (rad).
    pub positions: [f64; JOINTS],
    /// Joint velocities (rad/s).
    pub velocities: [f64; JOINTS],
    /// Pose of the end effector in the base frame, column-major (m).
    pub pose: [f64; 16],
    /// Twist of the end effector in the base frame: linear (m/s), angular (rad/s).
    pub twist: [f64; 6],
    /// Position of joint 3, by which the elbow is chosen (rad).
    pub elbow: Option<f64>,
    /// Torques without gravity and friction (N·m).
    pub torques: [f64; JOINTS],
    /// This command is the last one of its motion.
    pub is_finished: bool,
}

impl RobotCommand {
    /// The command in a datagram; `None` where it has another size.
    pub fn decode(datagram: &[u8]) -> Option<Self> {
        let mut body = Reader(datagram);
        let (message_id, positions) = (body.u64()?, body.f64s()?);
        let (velocities, pose, twist) = (body.f64s()?, body.f64s()?, body.f64s()?);
        let [elbow, _sign] = body.f64s()?;
        let has_elbow = body.u8()? != 0;
        let motion_finished = body.u8()? != 0;
        let torques = body.f64s()?;
        let torque_finished = body.u8()? != 0;
        body.0.is_empty().then_some(Self {
            message_id,
            positions,
            velocities,
            pose,
            twist,
            elbow: has_elbow.then_some(elbow),
            torques,
            is_finished: motion_finished || torque_finished,
        })
    }
}
