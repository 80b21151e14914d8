//! What every process of a cell has in common: how it starts, how it joins the
//! run, and how it says how it is doing.
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
