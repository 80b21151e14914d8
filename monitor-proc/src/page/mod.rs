//! Commands of a page and their recipients; no socket, no bus.

pub mod command;
pub mod desk;
mod fields;
pub mod rate;
pub mod role;
