//! Grasps of an object: candidates from its true size and pose, checked by exact shapes against
//! everything around it, best first.
//!
//! [`Scene`] has the bodies of a cell, [`Gripper`] the shapes of a tool, and [`grasps`] returns
//! every candidate with what excludes it. Nothing here moves an arm, reads a clock or knows a
//! bus. [`Reach`] searches the inverse kinematics of an arm.
//!
//! Units are m and rad; poses are in the world frame. Two fingers close along the y axis of the
//! TCP frame and point along its z axis. A suction cup points along the axis of its robot file.
#![forbid(unsafe_code)]

mod candidate;
mod cup;
mod directions;
mod fingers;
mod gripper;
mod plan;
mod reach;
mod report;
mod scene;
mod set_down;
mod solid;

pub use candidate::{Approach, Candidate, Depth, Exclusion};
pub use gripper::{Cup, Gripper, Hand};
pub use plan::{Grasps, first_grasps, grasps};
pub use reach::Reach;
pub use report::{GraspReport, GraspRow, TcpPose};
pub use scene::{Body, Scene};
pub use set_down::{SetDown, arm_in_the_way, set_down, touches};
pub use solid::Solid;
