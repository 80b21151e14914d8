//! Facts of a run that cell files and tasks use; the package `robocell-cell-run` has the others.

pub mod phase_name;
pub mod policy_name;
pub mod policy_server;
pub mod speed;
