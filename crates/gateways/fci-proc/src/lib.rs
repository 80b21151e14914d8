//! The Franka control interface (FCI) of an arm of the cell: a controller whose commands come
//! from a client program over the network.
//!
//! The robot behind the interface is `fci::Arm`, a pure core; [`cycle`] is one cycle of it with
//! messages of the bus, [`process`] joins it to the bus, and `net` to the sockets.
#![forbid(unsafe_code)]

pub mod cycle;
pub mod error;
mod gateway;
mod messages;
mod net;
pub mod process;

use std::process::ExitCode;

pub use gateway::FrankaInterface;

/// `main` of the program.
pub fn main() -> ExitCode {
    cell_worker::main("fci-proc", process::run)
}
