//! Settings and memory of the job.

use cell_model::{Cell, Shape};
use ipc_types::Pose;
use nalgebra::{Isometry3, Vector3};
use robocell_skills::matrix;
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{named, pose};
use robocell_task::{PolicyTime, SetupError};
use serde::{Deserialize, Serialize};

use super::numbers::FillBinTask;

/// One decision.
pub(super) type Turn<'t> = matrix::Turn<'t, FillBin>;

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Holding = "HOLDING",
    }
}

/// The settings of the cell file, and the values derived from them.
#[derive(Debug)]
pub(super) struct FillBin {
    pub(super) task: FillBinTask,
    /// The bin, by index in the cell file.
    pub(super) bin: usize,
    /// Its outer edge lengths (m).
    pub(super) size: Vector3<f64>,
    /// Thickness of its floor and walls (m).
    pub(super) wall_m: f64,
    /// Objects that may be in the bin: index in the cell file, and radius of the enclosing ball
    /// (m).
    pub(super) parts: Vec<(usize, f64)>,
    /// Base of the arm, world frame.
    pub(super) base: Isometry3<f64>,
    /// Bits of the obstacles that count while the bin is picked up: all but its stand.
    pub(super) beside_stand: u64,
    /// Pose of the TCP at rest.
    pub(super) rest: Pose,
}

impl FillBin {
    pub(super) fn new(task: &FillBinTask, cell: &Cell) -> Result<Self, SetupError> {
        let broken = |problem: String| SetupError::new(cell, problem);
        let base = suction_arm(cell)?.base;
        let bin = cell
            .object_index(&task.bin)
            .map_err(|error| broken(format!("task.bin: {error}")))?;
        let shape = cell.objects.get(bin).map(|object| &object.shape);
        let Some(Shape::Bin { size_m, wall_m }) = shape else {
            return Err(broken(format!("task.bin: '{}' is not a bin", task.bin)));
        };
        let objects = cell.objects.iter().enumerate();
        Ok(Self {
            bin,
            size: Vector3::from(*size_m),
            wall_m: *wall_m,
            parts: objects
                .filter(|(index, _)| *index != bin)
                .map(|(index, object)| (index, object.shape.bounding_radius()))
                .collect(),
            base,
            beside_stand: !obstacle_bits(cell, |name| task.stand.as_deref() == Some(name)),
            rest: pose::with_unit_quaternion(&Pose {
                position: task.default_position_m,
                orientation_wxyz: task.default_orientation_wxyz,
            }),
            task: task.clone(),
        })
    }
}

/// Numbers of the behaviour file.
pub(super) struct FillBinNumbers {
    /// Pace of the cup down to the surface (m/s).
    pub(super) slow_speed_m_s: f64,
    /// Free radius the cup needs on a floor with parts (m).
    pub(super) room_m: f64,
    /// Spots of the floor that are tried, as fractions of the space between the walls.
    pub(super) spots: Vec<f64>,
    /// Cosine of the largest angle between a side and the cup at which the side counts as held.
    pub(super) facing: f64,
    /// Cosine of the angle up to which a bin opens upward.
    pub(super) opens_up: f64,
}

/// The memory of the job; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "independent facts, each true or not"
)]
pub(super) struct Memory {
    /// An attachment that was not handled yet.
    pub(super) attached: bool,
    /// Time since which the bin cannot be picked up, or no part falls into it.
    pub(super) stuck_since: Option<PolicyTime>,
    /// The task was reset: a held object is released first.
    pub(super) let_go: bool,
    /// A grip broke since the job started.
    pub(super) broke: bool,
    /// A bin that hangs upside down was carried aside.
    pub(super) aside: bool,
}
