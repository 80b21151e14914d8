//! A drill: the whole cell under virtual time, with faults that a seed draws.
//!
//! Supervisor, the loops of all processes and models of bus, disk and processes run in one
//! thread. Everything depends on a [`plan::Plan`]; the invariants ([`check`]) are asked at every
//! message. docs/simulation.md says how to use it, and how to add an invariant.
#![forbid(unsafe_code)]

pub mod batch;
pub mod check;
pub mod coverage;
pub mod draw;
pub mod export;
pub mod fidelity;
pub mod model;
mod observer;
mod people;
pub mod plan;
pub mod planted;
pub mod reduce;
pub mod run;
pub mod scene;
mod stub;
