//! Code that all processes of a cell share: their start, joining the run, and their health.
#![forbid(unsafe_code)]

mod health;
mod loop_class;
mod orphan;
mod start;
mod warn;

pub use health::HealthReporter;
pub use loop_class::LoopClass;
pub use start::{RunError, SetupError, Start, main, main_of};
pub use warn::warn;
