//! The monitor: sees everything, slows down no other process, and may be killed at any time.
//!
//! It writes the task's log for people (`logs/trace.log` in the run directory) and serves the
//! page (docs/page-protocol.md): a [`feed::publisher`] reads the bus into a [`feed::broadcast`],
//! which sends it to all open pages; commands of pages go to a command queue
//! ([`operator::queue`]) that has them executed.
#![forbid(unsafe_code)]

pub mod feed;
pub mod operator;
pub mod page;
pub mod process;
pub mod recorder;
pub mod replay;
pub mod timeline;
pub mod trace;
pub mod web;
