//! The controller of one arm: joint commands at 1 kHz from what is measured and
//! what the task wants.
//!
//! The cycle itself is [`cycle::Cycle::update`]; [`process`] joins it to the
//! bus.
#![forbid(unsafe_code)]

pub mod controller;
pub mod corridor;
pub mod gripper_controller;
pub mod robot_state;
