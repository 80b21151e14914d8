//! What the job knows before it begins.

use std::sync::Arc;

use crate::fill_bin::numbers::FillBinTask;
use behavior::matrix::Table;
use cell_model::{Cell, Shape};
use ipc_types::Pose;
use nalgebra::{Isometry3, Vector3};

use super::names::{Event, Handler, State};
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{geometry, matrix, pose};
use robocell_task::SetupError;
use robocell_task::time::PolicyTime;

/// The cup stands still at the surface for this long before suction is switched
/// on: what it still moves then loads the grip.
const SETTLE: PolicyTime = PolicyTime::from_ticks(400);

/// The numbers of the cell file and what follows from them.
#[derive(Debug)]
pub(super) struct FillBinSetup {
    pub(super) task: FillBinTask,
    pub(super) table: Arc<Table>,
    /// The bin, by index in the cell file.
    pub(super) bin: usize,
    /// Its outer edge lengths (m).
    pub(super) size: Vector3<f64>,
    /// Thickness of its floor and walls (m).
    pub(super) wall_m: f64,
    /// What may lie in it, by index in the cell file, with the radius of the
    /// ball that holds it (m).
    pub(super) parts: Vec<(usize, f64)>,
    /// Base of the arm in the world frame.
    pub(super) base: Isometry3<f64>,
    /// Obstacles that count while the bin is picked up: all but its stand.
    pub(super) beside_stand: u64,
    /// Where the cup rests.
    pub(super) rest: Pose,
    pub(super) times: Times,
}

/// Lengths of time of the job.
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    pub(super) lift: PolicyTime,
    pub(super) carry: PolicyTime,
    pub(super) between_drops: PolicyTime,
    pub(super) settle: PolicyTime,
    pub(super) attach: PolicyTime,
    pub(super) state: PolicyTime,
    pub(super) patience: PolicyTime,
}

impl FillBinSetup {
    pub(super) fn new(task: &FillBinTask, cell: &Cell) -> Result<Self, SetupError> {
        let broken = |problem: String| SetupError::new(cell, problem);
        let arm = suction_arm(cell)?;
        let table = matrix::table::<Event, State, Handler>(cell, &task.behaviour)?;
        let bin = cell
            .object_index(&task.bin)
            .map_err(|error| broken(format!("task.bin: {error}")))?;
        let shape = cell.objects.get(bin).map(|object| &object.shape);
        let Some(Shape::Bin { size_m, wall_m }) = shape else {
            return Err(broken(format!("task.bin: '{}' is no bin", task.bin)));
        };
        let seconds = PolicyTime::from_seconds;
        Ok(Self {
            bin,
            size: Vector3::from(*size_m),
            wall_m: *wall_m,
            parts: parts(cell, bin),
            base: arm.base,
            beside_stand: !obstacle_bits(cell, |name| task.stand.as_deref() == Some(name)),
            rest: Pose {
                position: task.default_position_m,
                // Four decimals are no unit quaternion yet.
                orientation_wxyz: pose::wxyz(&geometry::rotation(task.default_orientation_wxyz)),
            },
            times: Times {
                lift: seconds(task.lift_s),
                carry: seconds(task.carry_s),
                between_drops: seconds(task.drop_interval_s),
                settle: SETTLE,
                attach: seconds(task.attach_s),
                state: seconds(task.state_timeout_s),
                patience: seconds(task.patience_s),
            },
            table: Arc::new(table),
            task: task.clone(),
        })
    }
}

fn parts(cell: &Cell, bin: usize) -> Vec<(usize, f64)> {
    let objects = cell.objects.iter().enumerate();
    objects
        .filter(|(index, _)| *index != bin)
        .map(|(index, object)| (index, object.shape.bounding_radius()))
        .collect()
}
