//! Stacking cubes: what the library-free state machine and the if/else
//! controller share. Numbers come from `[task]` of the cell file.

pub mod command;
pub mod feedback;
pub mod geometry;
pub mod grip;
pub mod phase;
pub mod picture;
pub mod recovery;
pub mod resume;
pub mod scene;
pub mod selection;
pub mod setup;

pub use phase::Phase;
pub use scene::Scene;
pub use setup::{SetupError, StackSetup};
