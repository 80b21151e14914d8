//! Benches of transport and clock.
//!
//! Only ratios within one run are comparable: every row of a bench is measured in turn with the
//! others, on the same cores, in the same minutes.

pub(crate) mod ipc;
mod links;
pub(crate) mod loop_;
pub(crate) mod peer;
mod site;

use thiserror::Error;

use crate::error::CoreError;

/// Errors of these benches.
#[derive(Debug, Error)]
pub(crate) enum BenchError {
    /// Error of a file, pipe, socket or process.
    #[error("the bench cannot {what}: {source}")]
    Io {
        /// The operation that failed.
        what: &'static str,
        /// Reason of the failure.
        source: std::io::Error,
    },
    /// A scene whose state is kept.
    #[error("the bench has no scene: {0}")]
    Scene(#[from] CoreError),
    /// Error of shared memory.
    #[error("the bench has no transport: {0}")]
    Bus(String),
    /// The other process did not answer.
    #[error(
        "the bench's second process did not answer within 2 s; the machine may be overloaded, run it again"
    )]
    Silent,
    /// The message received differs from the one sent.
    #[error("the bench received {got} for {sent}: this is a defect, please report it")]
    Wrong {
        /// First value sent.
        sent: f64,
        /// First value received.
        got: f64,
    },
    /// Unexpected output of another program.
    #[error("cannot read the result of {0}")]
    Foreign(&'static str),
}

/// Names the operation that failed.
pub(crate) fn io(what: &'static str) -> impl FnOnce(std::io::Error) -> BenchError {
    move |source| BenchError::Io { what, source }
}

/// A failure of the transport, as text.
pub(crate) fn bus(error: impl core::fmt::Debug) -> BenchError {
    BenchError::Bus(format!("{error:?}"))
}
