//! A run of a cell, for the processes that take part in it: its files, its summary and its
//! messages as JSON.
//!
//! The launcher writes [`spec::RunSpec`] and every process reads it; processes and the launcher
//! leave reports beside it, which become the [`summary::RunSummary`].
#![forbid(unsafe_code)]

pub mod children;
pub mod incident;
pub mod message;
pub mod output;
mod phases;
pub mod python;
pub mod record;
pub mod report;
pub mod script_report;
pub mod secrets;
pub mod spec;
pub mod summary;
mod summary_text;
pub mod wire;
pub mod worker_args;
