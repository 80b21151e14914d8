//! Recordings of a cell: MCAP files that other tools can open, the flight recorder's ring of
//! them, and reading both. No bus, no clock: messages and times are arguments. The format is
//! described in docs/recording.md.
#![forbid(unsafe_code)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "lengths are limited before they are cast, and times of a run are no larger than centuries"
)]

mod channel;
mod chunk;
mod container;
mod copy;
mod entry;
mod epoch;
mod error;
mod flight;
pub mod foxglove;
mod frame;
mod index;
mod layout;
mod links;
mod pack;
mod page;
mod recording;
mod solids;
mod storage;
mod writer;

pub use channel::Channel;
pub use copy::Copied;
pub use entry::{Cut, Entry, Message, wire_bytes};
pub use epoch::EpochSpan;
pub use error::RecordError;
pub use flight::{Flight, gap, gap_message};
pub use frame::Frame;
pub use pack::{pack, unpack};
pub use recording::{Entries, Recording};
pub use storage::{Disk, Storage};
pub use writer::{Preamble, RecordingWriter};

/// Profile in the header of our files.
pub const PROFILE: &str = "robocell";
