//! Code that all processes of a cell share: their start, joining the run, the loop with its
//! waits and inputs, checkpoints for the recorder, and their health.
#![forbid(unsafe_code)]

mod arm_loop;
mod gated;
mod health;
mod keyframes;
mod loop_class;
mod orphan;
mod start;
mod turn;
mod warn;

pub use arm_loop::{ArmLoop, Ended};
pub use gated::{DELIVERY_NS, Gated};
pub use health::HealthReporter;
pub use keyframes::Keyframes;
pub use loop_class::LoopClass;
pub use start::{RunError, SetupError, Start, main, main_of};
pub use turn::{Turn, Wait, Woken, run};
pub use warn::{keep_lines, warn};
