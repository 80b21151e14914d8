//! Benches of the ground the cell stands on: transport and clock.
//!
//! Ratios within one run are what counts: every row of a bench is measured in
//! turn with the others, on the same cores, in the same minutes.

pub(crate) mod ipc;
mod links;
pub(crate) mod loop_;
pub(crate) mod peer;
mod site;

use thiserror::Error;

use crate::error::CoreError;

/// A bench could not be carried through.
#[derive(Debug, Error)]
pub(crate) enum BenchError {
    /// A file, pipe, socket or process made trouble.
    #[error("the bench cannot {what}: {source}")]
    Io {
        /// What was being done.
        what: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A scene whose state is kept.
    #[error("the bench has no scene: {0}")]
    Scene(#[from] CoreError),
    /// Shared memory made trouble.
    #[error("the bench has no transport: {0}")]
    Bus(String),
    /// The other process did not answer.
    #[error(
        "the bench's second process did not answer within 2 s; the machine may be overloaded, run it again"
    )]
    Silent,
    /// What arrived is not what was sent.
    #[error("the bench received {got} for {sent}: this is a defect, please report it")]
    Wrong {
        /// First value sent.
        sent: f64,
        /// First value received.
        got: f64,
    },
    /// The other program said something unexpected.
    #[error("cannot read the result of {0}")]
    Foreign(&'static str),
}

/// Names what was being done when an operation failed.
pub(crate) fn io(what: &'static str) -> impl FnOnce(std::io::Error) -> BenchError {
    move |source| BenchError::Io { what, source }
}

/// A failure of the transport, as text.
pub(crate) fn bus(error: impl core::fmt::Debug) -> BenchError {
    BenchError::Bus(format!("{error:?}"))
}
