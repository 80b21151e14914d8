//! Kinds of behaviour descriptions: behaviour trees, declarative state
//! machines, and event matrices.
//!
//! All of them are loaded once, from Rust or from a file, and then ticked with
//! the time as an argument: a tick uses no heap, its work is bounded, and
//! the whole state between two ticks is one plain record that can
//! be saved after any tick and restored in another process.
//!
//! Trees have the semantics of `py_trees`, machines those of `transitions`,
//! except where those are defects: undefined names are refused when a file is
//! loaded, and a guard is evaluated once per event. No other engine was found with these
//! properties: one restarts the children of a nested sequence at every tick, others
//! allocate, or cannot save the state in the middle of a run.
#![forbid(unsafe_code)]

pub mod board;
pub mod descriptor;
pub mod finding;
pub mod graph;
pub mod inline;
mod known;
mod lines;
pub mod machine;
pub mod matrix;
pub mod numbers;
pub mod status;
pub mod suggest;
pub mod tree;
pub mod value;
pub mod views;

pub use finding::Finding;
pub use graph::Graph;
pub use status::{NodeStatus, ResetReason, Status};
pub use value::{Str, Value, ValueType};

/// The example of the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
