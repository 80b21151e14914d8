//! The controller of one arm: joint commands at 1 kHz from what is measured and
//! what the task wants.
//!
//! The cycle itself is [`cycle::Cycle::update`]; [`process`] joins it to the
//! bus.
#![forbid(unsafe_code)]

pub mod checkpoint;
pub mod controller;
mod convert;
pub mod corridor;
pub mod cycle;
pub mod error;
pub mod goal;
pub mod gripper_controller;
pub mod held_object;
pub mod obstacle_objects;
pub mod other_arm;
pub mod process;
pub mod rmpflow_controller;
pub mod robot_state;
pub mod suction;
pub mod surroundings;
