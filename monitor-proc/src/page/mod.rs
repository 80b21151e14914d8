//! Commands of a page and their recipients; no socket, no bus.

pub mod command;
mod fields;
pub mod queue;
pub mod rate;
pub mod role;
