//! Jobs of one arm whose decisions are a matrix of events and states in a file, with
//! conditions and handlers in Rust.
//!
//! A [`MatrixJob`] names its events and handlers and implements them; the file maps an event in
//! a state to a handler, and has the precision, times and distances. [`policy()`] joins the
//! two. The handlers of [`pick`] are those of a suction pick-up, for every job that gives the
//! spot at which its object can be gripped.

mod arm;
mod job;
pub mod pick;
mod policy;
mod run;

pub use arm::{ArmMemory, ArmNumbers, seconds};
pub use job::{Handler, MatrixJob, Pending, Seen, Turn, when};
pub use pick::{Approach, Spot, SuctionPick};
pub use policy::{load, policy};
pub use run::{MatrixRun, goto};
