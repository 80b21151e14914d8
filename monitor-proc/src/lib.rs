//! The monitor: sees everything, slows nobody, and may be killed at any time.
//!
//! It keeps the task's log for people (`logs/trace.log` in the run directory).
#![forbid(unsafe_code)]

pub mod journal;
pub mod process;
