//! Jobs of one arm whose decisions are a matrix of events and states in a file, with
//! conditions and handlers in Rust.
//!
//! A [`MatrixJob`] names its events and handlers and says what each does; the file
//! says which handler answers which event in which state, and with which
//! precision, times and distances. [`policy()`] joins the two. The handlers of
//! [`pick`] are those of a suction pick-up, for every job that says where its
//! object can be gripped.

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
