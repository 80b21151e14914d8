//! What the jobs of the UR10 have in common: poses of the suction cup, paths of
//! waypoints and when they count as reached, what becomes of a grip, and how a
//! job's behaviour file is read, run, told about and recorded.

mod grip_events;
mod kept_pose;
mod matrix_run;
mod motion;
mod named;
pub mod pose;
mod precision;
mod setup;
mod waypoint;

use nalgebra::Vector3;

pub use grip_events::{GripChange, GripMemory};
pub(crate) use grip_events::{break_cause, break_limit};
pub use kept_pose::KeptPose;
pub(crate) use kept_pose::within;
pub(crate) use matrix_run::{MatrixRun, goto, pending};
pub(crate) use motion::padded;
pub use motion::{Motion, Reached};
pub(crate) use named::{Named, named};
pub use precision::{PASSING, Precision, ROWS};
pub(crate) use setup::{matrix, obstacle_bits, suction_arm};
pub(crate) use waypoint::MAX_APPROACH_M;
pub use waypoint::{JOINTS, MAX_WAYPOINTS, Waypoint};

/// The one arm of these cells.
pub(crate) const ARM: usize = 0;

/// An arm nearer than this to its target is on its way, whatever happened (m).
const ON_THE_WAY_M: f64 = 0.25;

/// What a decision found out before it asks the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) grip: GripChange,
    pub(crate) reached: Reached,
}

/// Whether a cup measured there can go on to `target` as if nothing had happened.
pub(crate) fn on_the_way(target: &ipc_types::Pose, measured: &ipc_types::Pose) -> bool {
    let offset = Vector3::from(target.position) - Vector3::from(measured.position);
    offset.norm() <= ON_THE_WAY_M
}
