//! The robot and the world: joints and drives, gripper, objects.
//!
//! [`world::World`] is the pure core: one tick in, one tick out, no clock, no
//! port, no file. It simulates with rapier in double precision; a grasp holds by friction
//! alone. [`plant::Plant`] adds the clock switch.
#![forbid(unsafe_code)]

pub mod arm;
pub mod engine;
mod equipment;
pub mod error;
#[cfg(test)]
mod fault_tests;
mod gripper;
pub mod keeper;
pub mod operator;
pub mod plant;
pub mod process;
mod recorder_pace;
pub mod resume;
mod script_report;
mod state;
pub mod world;

use cell_model::Cell;

/// Sentences about properties of this cell that the engine does not simulate as expected.
pub fn warnings(cell: &Cell) -> Vec<String> {
    let mut warnings = engine::entered::warnings(cell);
    warnings.extend(engine::masses::warning(cell));
    warnings
}
