//! The task of a cell: what is to be done, decided a hundred times a second.
//!
//! The pure core: [`Task`] takes the newest [`ipc_types::WorldState`] and the
//! controllers' words and gives an [`ipc_types::Decision`]; time comes with the
//! state, and there is no clock, port, file or thread in here. A [`Policy`] sees
//! an [`Observation`] and speaks through an [`Output`]; what it and the task
//! remember is one plain [record], from which another process goes on.
//! An arm that nobody speaks for holds and keeps its gripper.
#![forbid(unsafe_code)]

pub mod bin_stack;
mod choice;
pub mod fill_bin;
pub mod goal_book;
pub mod job;
pub mod memory;
pub mod observation;
pub mod operator;
pub mod output;
pub mod palletize;
pub mod policy;
pub mod process;
pub mod pyramid;
pub mod reach;
pub mod record;
pub mod stack;
pub mod stack_bt;
pub mod stack_fsm;
pub mod stack_ifelse;
pub mod task;
pub mod time;
pub mod tracer;
pub mod tree_trace;
pub mod ur10;

pub use job::Job;
pub use observation::Observation;
pub use output::{Output, TraceLineText};
pub use policy::Policy;
pub use record::RecordError;
pub use task::{Task, TaskError};
pub use time::PolicyTime;
