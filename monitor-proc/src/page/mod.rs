//! What a page may ask for, and who carries it out; no socket, no bus.

pub mod command;
pub mod desk;
mod fields;
pub mod rate;
pub mod role;
