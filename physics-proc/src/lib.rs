//! The robot and the world: joints and drives, gripper, objects.
//!
//! [`world::World`] is the pure core: one tick in, one tick out, no clock, no
//! port, no file. It simulates with rapier in double precision; a grasp is
//! friction and nothing else. [`plant::Plant`] adds the clock switch.
#![forbid(unsafe_code)]

mod arm;
pub mod arm_contacts;
mod beam;
mod contacts;
mod convert;
mod conveyor;
mod cup;
mod dispenser;
pub mod drag;
mod equipment;
#[cfg(test)]
mod fault_tests;
mod fresh;
mod gripper;
mod hanging;
mod hash;
mod measured;
mod memory;
mod momentum;
mod objects;
mod operate;
mod panel;
mod parking;
pub mod plant;
pub mod process;
mod sensors;
pub mod settings;
mod shapes;
mod snapshot;
mod spawn;
mod state;
mod state_tap;
mod suction;
#[cfg(test)]
mod suction_tests;
mod supply;
mod tag;
mod violations;
pub mod watchdog;
pub mod world;
