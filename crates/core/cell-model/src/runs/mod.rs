//! A run of a cell, for the processes that take part in it.

pub mod children;
pub mod incident;
pub mod message;
pub mod output;
pub mod phase_name;
mod phases;
pub(crate) mod policy_name;
pub mod policy_server;
pub mod python;
pub mod record;
pub mod report;
pub mod script_report;
pub mod secrets;
pub mod spec;
pub mod speed;
pub mod summary;
mod summary_text;
pub mod wire;
pub mod worker_args;
