//! The controller of one arm: joint commands at 1 kHz from the measured state and the goal of
//! the task.
//!
//! The cycle itself is [`cycle::Cycle::update`]; [`process`] joins it to the
//! bus.
#![forbid(unsafe_code)]

pub mod arm_motion;
pub mod checkpoint;
pub mod controller;
pub mod controllers;
mod convert;
pub mod corridor;
pub mod cycle;
pub mod error;
pub mod follower;
pub mod goal;
pub mod gripper_controller;
pub mod held_object;
pub mod obstacle_objects;
pub mod other_arm;
pub mod planning;
pub mod process;
pub mod rmpflow_controller;
pub mod robot_state;
pub mod suction;
pub mod surroundings;

use std::process::ExitCode;

pub use controllers::Controllers;

/// `main` of a controller program with these controllers.
pub fn main(controllers: &Controllers) -> ExitCode {
    cell_worker::main("controller-proc", |start| process::run(start, controllers))
}
