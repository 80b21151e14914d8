//! Two arms take a pyramid of cubes apart, each after one behaviour tree that is
//! written in a file: one file, an instance for each arm.
//!
//! The trees share a blackboard. A cube is reserved by one arm at a time, and
//! one arm at a time owns the centre, where the pyramid stands. What an arm
//! believes about its stack is compared with what is seen whenever it matters,
//! so nothing is counted twice and nothing is lost without being noticed.

mod center;
mod cubes;
mod grip;
mod host;
mod keys;
mod library;
mod nodes;
mod phases;
mod policy;
mod setup;
mod targets;

#[cfg(test)]
mod tests;

pub use host::{PyramidHost, World};
pub use library::library;
pub use policy::Json;
pub use setup::{ArmSetup, CubeSetup, PyramidError, PyramidSetup};
