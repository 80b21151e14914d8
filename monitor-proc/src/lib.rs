//! The monitor: sees everything, slows no other process, and may be killed at any time.
//!
//! It keeps the task's log for people (`logs/trace.log` in the run directory)
//! and serves the page (docs/page-protocol.md): what it knows goes into a
//! [`hub`], from the bus, and from there to as many pages as look; commands of
//! pages go to a desk that carries them out.
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
