//! Errors of the bus; each message says what to do.

use std::path::PathBuf;

use thiserror::Error;

/// Joining a run, creating its services or opening a port failed.
#[derive(Debug, Error)]
pub enum BusError {
    /// The run's place has no valid name.
    #[error("the run's {what} `{value}` cannot be used: {allowed}")]
    Site {
        /// Root or prefix.
        what: &'static str,
        /// What was given.
        value: String,
        /// Valid values and the remedy.
        allowed: String,
    },
    /// A file operation failed.
    #[error("{path}: {source}; check that the directory belongs to you and has room", path = path.display())]
    Io {
        /// Path of the file or directory.
        path: PathBuf,
        /// Reason given by the system.
        source: std::io::Error,
    },
    /// Shared memory is too small; a write to it would end the process.
    #[error(
        "{path} has {free} bytes free, a cell with {arms} arm(s) needs {needed}: remove leftovers \
         (`robocell doctor` lists them) or enlarge it (`mount -o remount,size=256M {path}`; \
         in a container `--shm-size 256m`)", path = path.display()
    )]
    NoRoom {
        /// The shared memory file system.
        path: PathBuf,
        /// Bytes free.
        free: u64,
        /// Bytes needed.
        needed: u64,
        /// Arms of the cell.
        arms: u8,
    },
    /// The process cannot become a participant of the run.
    #[error(
        "cannot join the run at {root} ({reason}): check that the cell still runs \
         (`robocell status`) and that it was started by the same user", root = root.display()
    )]
    Join {
        /// Root of the run.
        root: PathBuf,
        /// The transport's reason.
        reason: String,
    },
    /// A service could not be created.
    #[error(
        "cannot create `{service}` ({reason}): end the cell with `robocell down` and start it again"
    )]
    Create {
        /// The service.
        service: String,
        /// The transport's reason.
        reason: String,
    },
    /// A service could not be opened within the time limit.
    #[error(
        "cannot open `{service}` within {waited_ms} ms ({reason}): the launcher creates it, so \
         check that the cell still runs (`robocell status`)"
    )]
    Open {
        /// The service.
        service: String,
        /// The transport's reason.
        reason: String,
        /// Time spent trying.
        waited_ms: u64,
    },
    /// The running cell was built from other message types.
    #[error(
        "`{service}` of the running cell carries {theirs}, this program speaks {ours}: they are of \
         different versions; end the cell with `robocell down` and start all programs from one build"
    )]
    Version {
        /// The service.
        service: String,
        /// Type and schema hash of the running cell.
        theirs: String,
        /// Type and schema hash of this program.
        ours: String,
    },
    /// All places for such ports on a service are taken.
    #[error(
        "`{service}` has at most {limit} {ports} at a time, and that many are open: close programs that \
         look on (`top`, `show --live`, pages); if none does, some crashed: start the cell again"
    )]
    NoPlace {
        /// The service.
        service: String,
        /// Kind of the ports.
        ports: &'static str,
        /// How many are possible.
        limit: usize,
    },
    /// No port could be made on an open service, for another reason.
    #[error(
        "no port on `{service}` ({reason}): check that the run directory and /dev/shm can be \
         written and have room (`robocell doctor`)"
    )]
    Port {
        /// The service.
        service: String,
        /// The transport's reason, and the error of the system where a file cannot be made.
        reason: String,
    },
}

/// A message was not sent. The sender does not block; the next one is a new attempt.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum PublishError {
    /// No memory to write into.
    #[error(
        "no memory for a message: {0:?}; the cell's shared memory is damaged, start the cell again"
    )]
    Loan(iceoryx2::port::LoanError),
    /// Not every reader got it.
    #[error("a message did not reach every reader: {0:?}")]
    Send(iceoryx2::port::SendError),
}

/// An operator's request got no answer.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RequestError {
    /// The request makes no sense and was not sent.
    #[error("the request was not sent: {0}")]
    Invalid(ipc_types::Invalid),
    /// The transport failed.
    #[error("the request was not sent ({0}): check that the cell still runs (`robocell status`)")]
    Send(String),
    /// Physics did not answer.
    #[error(
        "no answer within {0} ms: physics is being started, refused the request, hangs or has ended; \
         see `robocell status`"
    )]
    NoAnswer(u128),
}
