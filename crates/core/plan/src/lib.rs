//! Paths for arms: `RRT`-Connect (`Kuffner` and `LaValle`, 2000) in joint space on the spheres of
//! a robot, with shortcuts.
//!
//! [`plan`] finds a path between two configurations, [`plan_to_pose`] one to a pose of the
//! tool, [`Guide`] leads motion policies along it, and [`reason()`] gives the reason why an
//! arm is not at its target.
//!
//! Sixteen configurations of an edge are checked in one pass, spread over the whole edge, as
//! Thomason, Kingston and Kavraki describe ("Motions in Microseconds via Vectorized
//! Sampling-Based Planning", 2024).
//!
//! A controller computes a plan while it runs and a replay computes it again, so a change must
//! keep two properties (ADR 0019, ADR 0021):
//!
//! - A plan depends only on its inputs and the seed, to the bit and on every processor:
//!   nothing is fused, lanes are never added across, and no clock is read.
//! - Its effort is bounded, by iterations and by the number of comparisons with solids, so
//!   that an impossible request has an answer, too.
//!
//! A path that is reported has to be free, to the micrometre of single precision: an
//! approximation may only make a free path count as blocked, never the other way around.
//!
//! Units are m and rad; poses are in the base frame of the arm. Configurations are checked
//! in single precision, which is off by about a micrometre for an arm of a metre.
#![forbid(unsafe_code)]

mod body;
mod check;
mod follow;
mod gains;
mod halton;
mod ik;
mod lanes;
mod planner;
mod reason;
mod scene;
mod shortcut;
mod to_pose;
mod tree;

pub use body::{Body, BodyError, BodySetup};
pub use follow::{Ahead, Guide};
pub use gains::led;
pub use ik::{Found, Tool};
pub use lanes::LANES;
pub use planner::{Path, PlanError, Settings, plan};
pub use reason::{Reason, reason};
pub use scene::Scene;
pub use to_pose::{Request, plan_to_pose};

/// The example of the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
