//! The robot and the world: joints and drives, gripper, objects.
//!
//! [`world::World`] is the pure core: one tick in, one tick out, no clock, no
//! port, no file. It simulates with rapier in double precision; a grasp is
//! friction and nothing else. [`plant::Plant`] adds the clock switch.
#![forbid(unsafe_code)]

mod arm;
mod beam;
mod contacts;
mod convert;
mod cup;
pub mod drag;
#[cfg(test)]
mod fault_tests;
mod gripper;
mod hanging;
mod hash;
mod measured;
mod memory;
mod objects;
mod operate;
mod panel;
pub mod plant;
pub mod process;
pub mod settings;
mod shapes;
mod snapshot;
mod spawn;
mod state;
mod state_tap;
mod suction;
#[cfg(test)]
mod suction_tests;
mod tag;
mod violations;
pub mod watchdog;
pub mod world;
