//! Supervision of the processes of a cell, and the files they share.
//!
//! [`run::LiveCell`] starts the processes of a [`run::plan::Plan`] and keeps them running.
//! Commands find its run directory ([`rundir`]) and send requests ([`control`]). The command
//! line is the launcher's.
#![forbid(unsafe_code)]

pub mod child;
pub mod control;
pub mod failure;
pub mod flight;
pub mod leftovers;
pub mod lock;
pub mod process_log;
pub mod programs;
pub mod run;
pub mod rundir;
pub mod say;
pub mod supervision;
