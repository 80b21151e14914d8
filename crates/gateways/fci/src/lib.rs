//! The robot's side of the Franka control interface (FCI), version 10 of the arm and 3 of the
//! hand, as pure functions: requests and datagrams of a client in, setpoints, states and
//! replies out. Sockets and clocks are those of the caller.
//!
//! Layouts and numbers are those of frankarobotics/libfranka-common and libfranka 0.21.
#![forbid(unsafe_code)]

mod arm;
mod bytes;
mod datagram;
mod error;
mod follow;
mod gripper;
mod hand;
mod kinematics;
mod limits;
mod motion;
mod request;
mod state;
mod urdf;

pub use arm::{
    Arm, ArmMemory, LOST_ANSWERS, LateAnswer, Measured, NotSevenJoints, Reflex, Setpoint,
};
pub use datagram::{COMMAND_BYTES, ELBOW_FLIP, Elbow, RobotCommand};
pub use error::{ERROR_COUNT, Error, Errors};
pub use gripper::{
    Fingers, GRIPPER_HEADER_BYTES, GRIPPER_REQUEST_BYTES, GRIPPER_STATE_BYTES, GRIPPER_VERSION,
    Gripper, GripperFramed, GripperReply, GripperRequest, decode_gripper,
};
pub use motion::Broken;
pub use request::{
    Framed, HEADER_BYTES, Malformed, MoveRequest, MoveStatus, REQUEST_BYTES, Reply, Request,
    VERSION, decode,
};
pub use state::STATE_BYTES;
pub use urdf::urdf;

/// Joints of the arm.
pub const JOINTS: usize = 7;
