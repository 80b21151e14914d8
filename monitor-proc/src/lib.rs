//! The monitor: sees everything, slows down no other process, and may be killed at any time.
//!
//! It writes the task's log for people (`logs/trace.log` in the run directory) and serves the
//! page (docs/page-protocol.md): the bus feeds a [`hub`], which feeds all open pages; commands
//! of pages go to a desk that has them executed.
#![forbid(unsafe_code)]

mod breaks;
pub mod desk;
pub mod events;
pub mod feed;
pub mod film;
pub mod hub;
mod incidents;
pub mod journal;
pub mod keep;
pub mod lanes;
pub mod live;
pub mod misses;
pub mod pace;
pub mod page;
pub mod policy_file;
pub mod process;
pub mod recorder;
pub mod replay;
mod reset;
pub mod scene;
pub mod scrub;
pub mod snapshot;
mod starts;
pub mod status;
pub mod story;
pub mod web;
