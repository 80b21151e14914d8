//! The interface for authors of tasks. Pure: no bus, no physics, no page.
//!
//! A [`Policy`] receives an [`Observation`], keeps its state in its memory type, and
//! writes its decision into an [`Output`]. [`Policies`] is the registry of a program:
//! kinds of `[task]` tables in cell files, and the policies of each. A [`Task`] runs one
//! policy, together with the operator's panel, the checkpoint from which it resumes
//! after SIGKILL, and the trace for people.
#![forbid(unsafe_code)]

mod breakpoints;
pub mod checkpoint;
mod client;
pub mod error;
pub mod goal_book;
pub mod goals;
pub mod inputs;
pub mod job;
pub mod observation;
pub mod operator;
pub mod output;
mod perception;
pub mod policy;
mod ranges;
pub mod reason;
pub mod registry;
pub mod remote;
pub mod replaced;
pub mod ring;
pub mod settings;
pub mod starts;
pub mod task;
pub mod time;
pub mod trace;
pub mod tree_trace;
pub mod trees;

pub use checkpoint::CheckpointError;
pub use goals::{Goals, Slots};
pub use ipc_types::decision::{GoalKind, Outcome};
pub use ipc_types::trace::TraceEvent;
pub use ipc_types::{GripperGoal, Pose};
pub use job::Job;
pub use observation::Observation;
pub use output::{ArmIntent, Output, TraceLineText};
pub use policy::{AnyPolicy, Policy, boxed};
pub use reason::Reason;
pub use registry::{Kind, Policies, TaskError};
pub use remote::Remote;
pub use settings::{NoSettings, Settings, SetupError};
pub use task::{Restored, Task};
pub use time::PolicyTime;
pub use trees::{TreeError, TreeTools};

/// The example of the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
