//! What a robot, a scene, a run and a stop are; no engine, no bus.
//!
//! [`Cell::load`] is the way in: it reads `cells/NAME.toml` and the robots it
//! names from a [`Data`] source, checks everything, and places the objects for
//! a seed.
#![forbid(unsafe_code)]

pub mod cell;
mod cell_check;
mod cell_check_equipment;
pub mod cell_file;
pub mod check;
pub mod data;
pub mod dynamics;
pub mod error;
pub mod ramp;
pub mod random;
pub mod rmpflow_file;
pub mod robot;
mod robot_file;
mod robot_load;
mod robot_motion;
pub mod robot_user;
pub mod run_spec;
pub mod script;
mod script_check;
pub mod shape;
pub mod stop;
pub mod summary;
pub mod task_table;
mod toml_text;
pub mod urdf;
mod urdf_check;
mod urdf_scan;
pub mod worker_args;
pub mod xrdf;

pub use behavior::suggest;
pub use cell::{ArmSpec, Cell, FixtureSpec, ObjectSpec};
pub use check::Checker;
pub use data::Data;
pub use dynamics::Dynamics;
pub use error::ModelError;
pub use robot::{JointSpec, ParallelGripper, Robot, SuctionGripper};
pub use robot_user::RobotFiles;
pub use shape::{Link, LinkShape, Shape};
pub use task_table::TaskTable;
