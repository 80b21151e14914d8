//! Data types and files of robots, scenes and stops, without engine and bus.
//!
//! [`Cell::load`] is the entry point: it reads `cells/NAME.toml` and its robots from a [`Data`]
//! source, checks everything, and places the objects for a seed.
#![forbid(unsafe_code)]

pub mod cells;
pub mod check;
pub mod data;
pub mod draft;
mod encoding;
pub mod error;
pub mod ramp;
pub mod random;
pub mod robots;
pub mod runs;
pub mod shape;
pub mod stop;
mod toml_text;
pub mod user_file;

pub use behavior::suggest;
pub use cells::cell::{ArmSpec, CLIENT_CONTROLLER, Cell, FixtureSpec, ObjectSpec};
pub use cells::task_table::TaskTable;
pub use check::Checker;
pub use data::Data;
pub use error::{Location, ModelError};
pub use robots::dynamics::Dynamics;
pub use robots::files::RobotFiles;
pub use robots::robot::{JointSpec, ParallelGripper, Robot, SuctionGripper, VelocityEnvelope};
pub use robots::self_distance::SelfDistance;
pub use shape::{Link, LinkShape, Panel, Shape};
