//! What the job is about, worked out once from the cell file.

use std::sync::Arc;

use crate::palletize::numbers::PalletizeTask;
use behavior::machine::{Definition, Table};
use cell_model::{Cell, Shape};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::geometry::BinShape;
use super::table;
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{Named as _, geometry};
use robocell_task::SetupError;
use robocell_task::settings::behaviour_text;

/// Names of the fixtures that keep the arm away from places only part of the
/// time.
mod obstacle {
    /// Around the jig.
    pub(crate) const FLIP_SPHERE: &str = "flip_sphere";
    /// Keeps the tool up between the two sides.
    pub(crate) const DOME: &str = "navigation_dome";
    /// Stands between the two sides.
    pub(crate) const BARRIER: &str = "navigation_barrier";
    /// Around the jig's stand.
    pub(crate) const FLIP_BARRIER: &str = "flip_barrier";
}

/// Bits of [`ipc_types::ArmGoal::obstacle_mask`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ObstacleBits {
    /// The jig's surroundings.
    pub(super) flip_sphere: u64,
    /// What is between the two sides: dome and barrier.
    pub(super) between: u64,
    /// The jig's stand.
    pub(super) flip_barrier: u64,
}

/// A bin of the cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BinSpec {
    /// Index in the cell file.
    pub(super) object: usize,
    /// Name in the cell file.
    pub(super) name: String,
    /// Its measures.
    pub(super) shape: BinShape,
}

/// The job.
#[derive(Debug)]
pub(super) struct PalletizeSetup {
    /// Numbers of the cell file.
    pub(super) numbers: PalletizeTask,
    /// All bins, in the order of the cell file.
    pub(super) bins: Vec<BinSpec>,
    /// Bins that shall stand on the pallet at the end.
    pub(super) wanted: usize,
    /// Centres of the places in the order in which they are filled, with the
    /// bin's long side along y.
    pub(super) slots: Vec<Isometry3<f64>>,
    /// Rest pose of the tool.
    pub(super) home: Isometry3<f64>,
    /// The tool where it lets go of a bin to be turned.
    pub(super) flip: Isometry3<f64>,
    /// Joints in the cell's posture.
    pub(super) home_joints: Vec<f64>,
    /// Obstacles that come and go.
    pub(super) obstacles: ObstacleBits,
    /// The rows.
    pub(super) table: Arc<Table>,
}

impl PalletizeSetup {
    /// The job of `cell`.
    ///
    /// # Errors
    /// [`SetupError`] with what is missing or too much.
    pub(super) fn new(task: &PalletizeTask, cell: &Cell) -> Result<Self, SetupError> {
        let refuse = |problem: String| SetupError::new(cell, problem);
        let arm = suction_arm(cell)?;
        let supply = cell.conveyor.as_ref().and_then(|c| c.supply.as_ref());
        let kind = supply.map(|s| s.objects.as_str()).unwrap_or_default();
        let bins = bins(cell, kind);
        let slots = slots(task);
        let wanted = cell.bins.min(bins.len());
        if wanted == 0 || wanted > slots.len() {
            return Err(refuse(format!(
                "{wanted} bins for {} places of the pallet; give the pallet more, or use --bins",
                slots.len()
            )));
        }
        let joints = arm.robot.with_arm_positions(&arm.home);
        let tool = arm.robot.frame_pose(arm.robot.tcp_frame, &joints);
        Ok(Self {
            home: arm.base * tool.unwrap_or_else(Isometry3::identity),
            home_joints: arm.home.clone(),
            flip: Isometry3::from_parts(
                Translation3::from(task.flip.position_m),
                geometry::rotation(task.flip.orientation_wxyz),
            ),
            obstacles: guides(cell)?,
            table: Arc::new(behaviour(task, cell)?),
            numbers: task.clone(),
            bins,
            wanted,
            slots,
        })
    }

    /// Name of a bin, by its place in `bins`.
    pub(super) fn name(&self, bin: usize) -> &str {
        self.bins.get(bin).map_or("?", |b| b.name.as_str())
    }
}

fn bins(cell: &Cell, kind: &str) -> Vec<BinSpec> {
    let objects = cell.objects.iter().enumerate();
    objects
        .filter(|(_, object)| object.kind == kind)
        .filter_map(|(index, object)| match object.shape {
            Shape::Bin { size_m, wall_m } => Some(BinSpec {
                object: index,
                name: object.name.clone(),
                shape: BinShape {
                    size: Vector3::from(size_m),
                    wall: wall_m,
                },
            }),
            _ => None,
        })
        .collect()
}

fn slots(task: &PalletizeTask) -> Vec<Isometry3<f64>> {
    // Long sides lie along y.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(h, 0.0, 0.0, h));
    let row = |x: f64| {
        let at =
            move |y: &f64| Isometry3::from_parts(Translation3::new(x, *y, task.slot_z_m), turn);
        task.slot_y_m.iter().map(at)
    };
    task.slot_x_m.iter().copied().flat_map(row).collect()
}

fn guides(cell: &Cell) -> Result<ObstacleBits, SetupError> {
    let bit = |name: &str| match obstacle_bits(cell, |known| known == name) {
        0 => Err(SetupError::new(
            cell,
            format!("this job needs a [[fixture]] '{name}' with obstacle = true"),
        )),
        bit => Ok(bit),
    };
    Ok(ObstacleBits {
        flip_sphere: bit(obstacle::FLIP_SPHERE)?,
        between: bit(obstacle::DOME)? | bit(obstacle::BARRIER)?,
        flip_barrier: bit(obstacle::FLIP_BARRIER)?,
    })
}

fn behaviour(task: &PalletizeTask, cell: &Cell) -> Result<Table, SetupError> {
    let refuse = |problem: String| SetupError::new(cell, problem);
    let file = &task.behaviour;
    let text = behaviour_text(cell, file)?;
    let table = Definition::load(&format!("cells/{file}"), &text, &table::vocabulary())
        .map_err(|problems| refuse(problems.to_string()))?;
    for name in table::State::NAMES {
        if table.state(name).is_none() {
            return Err(refuse(format!(
                "{file} has no state '{name}'; this job needs it"
            )));
        }
    }
    Ok(table)
}
