//! What a job knows before it begins.

use std::sync::Arc;

use crate::bin_stack::numbers::BinStackTask;
use behavior::matrix::Table;
use cell_model::{Cell, Shape};

use super::columns::Columns;
use super::names::{Event, Handler, State};
use robocell_skills::matrix;
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_task::SetupError;

/// Fixtures of the flipping station have names that begin so.
const HOLDER: &str = "holder";

/// The numbers of the cell file and what follows from them.
#[derive(Debug)]
pub(super) struct BinStackSetup {
    pub(super) task: BinStackTask,
    pub(super) table: Arc<Table>,
    pub(super) columns: Columns,
    /// Names of all objects.
    pub(super) names: Vec<String>,
    /// Objects that are bins, by index in the cell file.
    pub(super) bins: Vec<usize>,
    /// Bins the job is about.
    pub(super) wanted: usize,
    /// Height of a bin (m).
    pub(super) height_m: f64,
    /// Thickness of its floor (m).
    pub(super) wall_m: f64,
    /// Which of the cell's sensors sees the end of the belt.
    pub(super) sensor: usize,
    /// Obstacles but for those of the flipping station.
    pub(super) without_holder: u64,
    /// Limits of the arm's joints (rad).
    pub(super) joints: Vec<(f64, f64)>,
    pub(super) seed: u64,
}

impl BinStackSetup {
    pub(super) fn new(task: &BinStackTask, cell: &Cell) -> Result<Self, SetupError> {
        let arm = suction_arm(cell)?;
        let table = matrix::table::<Event, State, Handler>(cell, &task.behaviour)?;
        let bins: Vec<usize> = (0..cell.objects.len())
            .filter(|index| {
                let object = cell.objects.get(*index);
                object.is_some_and(|object| object.kind == task.bins)
            })
            .collect();
        let shape = bins
            .first()
            .and_then(|index| cell.objects.get(*index))
            .map(|object| &object.shape);
        let Some(Shape::Bin { size_m, wall_m }) = shape else {
            return Err(SetupError::new(
                cell,
                "task.bins names nothing with the shape of a bin",
            ));
        };
        let sensor = cell.sensors.iter().position(|s| s.name == task.sensor);
        let sensor =
            sensor.ok_or_else(|| SetupError::new(cell, "task.sensor names no [[sensor]]"))?;
        Ok(Self {
            table: Arc::new(table),
            columns: Columns::new(task.stack.clone(), size_m[2]),
            names: cell.objects.iter().map(|o| o.name.clone()).collect(),
            wanted: bins.len().min(cell.bins),
            bins,
            height_m: size_m[2],
            wall_m: *wall_m,
            sensor,
            without_holder: !obstacle_bits(cell, |name| name.starts_with(HOLDER)),
            joints: arm.robot.arm_specs().map(|j| (j.lower, j.upper)).collect(),
            seed: cell.seed,
            task: task.clone(),
        })
    }

    /// Name of an object.
    pub(super) fn name(&self, object: usize) -> &str {
        self.names.get(object).map_or("?", String::as_str)
    }
}
