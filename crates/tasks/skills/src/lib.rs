//! Building blocks of tasks, independent of any job: motions, grips, picking, placing, waiting,
//! equipment, and conditions about the observed cell.
//!
//! They are used in four ways: from Rust, where a [`World`] is the view of one arm and every
//! skill is a value with a [`Skill::step`]; as node types of a JSON tree; as steps of a state
//! in a machine file; and as steps of a handler in a matrix file. [`with_file_jobs`] adds the
//! three kinds of `[task]` that need no Rust: `tree`, `machine` and `matrix`.
//!
//! [`path`] has motions over several waypoints, [`shared`] the communication between arms in
//! one cell, and [`MachineRun`] and [`matrix`] run a machine or a matrix whose actions are in
//! Rust.
//!
//! How a skill works and recovers is decided here. No code here depends on a cube, a bin or a
//! demo.
#![forbid(unsafe_code)]

pub mod ability;
pub mod attempts;
mod choice;
pub mod condition;
pub mod equipment;
pub mod files;
pub mod fingers;
pub mod geometry;
pub mod grip;
pub mod machine_run;
pub mod matrix;
pub mod motion;
mod named;
pub mod nodes;
pub mod path;
pub mod pick;
pub mod place;
pub mod pose;
pub mod progress;
mod refusal;
mod set_down;
pub mod settings;
pub mod setup;
pub mod shared;
pub mod skill;
pub mod suction;
pub mod way;
pub mod world;

pub use behavior::Status;
pub use condition::Condition;
pub use equipment::{AddBin, Conveyor, DropParts, Wait};
pub use files::with_file_jobs;
pub use grip::{Close, Open};
pub use machine_run::MachineRun;
pub use motion::{FollowOperator, Home, MoveTo, Target};
pub use named::Named;
pub use path::{Paces, Path, Precision, Reached, Route, Waypoint};
pub use pick::Pick;
pub use place::Place;
pub use pose::KeptPose;
pub use progress::{Progress, Step};
pub use refusal::{Refusal, ZoneWait};
pub use settings::{FileTask, PlaceTable, Places};
pub use setup::{ArmSetup, ObjectSetup, PlaceSetup, Setup, Tool};
pub use shared::{Lease, Owner, Recovery, Reservations};
pub use skill::{Skill, SkillLeaf, Station};
pub use way::Way;
pub use world::{ArmMemory, Told, World};

/// The example of the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
