//! The command of a client for one cycle, over UDP (libfranka-common,
//! `research_interface/robot/rbk_types.h`, version 10).

use serde::{Deserialize, Serialize};

use crate::JOINTS;
use crate::bytes::Reader;

/// Bytes of a command.
pub const COMMAND_BYTES: usize = 371;

/// The elbow of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elbow {
    /// Position of joint 3 (rad).
    pub position: f64,
    /// Flip direction of joint 4: 1, or -1 below [`ELBOW_FLIP`].
    pub sign: f64,
}

/// The position of joint 4 with which the arm is longest (rad; `robot_specifications.rst` of the
/// maker).
pub const ELBOW_FLIP: f64 = -0.467_002_423_653_011;

impl Elbow {
    /// That of an arm with these joint positions (rad).
    pub fn of(positions: &[f64; JOINTS]) -> Self {
        Self {
            position: positions[2],
            sign: match positions[3].total_cmp(&ELBOW_FLIP) {
                std::cmp::Ordering::Less => -1.0,
                std::cmp::Ordering::Equal => 0.0,
                std::cmp::Ordering::Greater => 1.0,
            },
        }
    }
}

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
    /// Which of the positions with the same pose is wanted.
    pub elbow: Option<Elbow>,
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
        let [position, sign] = body.f64s()?;
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
            elbow: has_elbow.then_some(Elbow { position, sign }),
            torques,
            // A client sets the flag of the generator or of the controller, as its motion has one.
            is_finished: motion_finished || torque_finished,
        })
    }
}
