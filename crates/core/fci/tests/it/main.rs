//! The robot's side of the Franka control interface, as a client sees it.
#![allow(clippy::unwrap_used, reason = "tests")]

mod gripper;
mod messages;
mod motions;
mod support;
