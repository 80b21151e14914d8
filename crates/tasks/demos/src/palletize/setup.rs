//! The job, prepared once from the cell file.

use std::sync::Arc;

use behavior::machine::{Definition, Table};
use cell_model::{Cell, Shape};
use ipc_types::MAX_JOINTS;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector2, Vector3};
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{Named as _, Setup, geometry::rotation};
use robocell_task::SetupError;
use robocell_task::settings::behaviour_text;

use super::geometry::BinShape;
use super::numbers::PalletizeTask;
use super::steps::Sequence;
use super::table;
use super::work_kind::WorkKind;

/// Bits of [`ipc_types::ArmGoal::obstacle_mask`] of the fixtures that keep the arm away from
/// places only part of the time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ObstacleBits {
    /// Around the jig.
    pub(super) flip_sphere: u64,
    /// Between the two sides: a dome that keeps the tool up, and a barrier.
    pub(super) between: u64,
    /// Around the jig's stand.
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
    /// The settings.
    pub(super) task: PalletizeTask,
    /// All bins, in the order of the cell file.
    pub(super) bins: Vec<BinSpec>,
    /// Number of bins that have to be on the pallet at the end.
    pub(super) wanted: usize,
    /// Centres of the places in the order in which they are filled, with the
    /// bin's long side along y, world frame.
    pub(super) slots: Vec<Isometry3<f64>>,
    /// Base of the arm in the plane, world frame (m).
    pub(super) base: Vector2<f64>,
    /// Rest pose of the tool, world frame.
    pub(super) home: Isometry3<f64>,
    /// Joint positions there (rad).
    pub(super) home_joints: [f64; MAX_JOINTS],
    /// Pose of the tool where it releases a bin to be turned, world frame.
    pub(super) jig: Isometry3<f64>,
    /// Obstacles that do not always count.
    pub(super) obstacles: ObstacleBits,
    /// The shapes of all objects.
    pub(super) solids: Setup,
    /// The machine.
    pub(super) table: Arc<Table>,
    sequences: [Sequence; 6],
}

impl PalletizeSetup {
    /// The job of `cell`.
    ///
    /// # Errors
    /// Returns a [`SetupError`] that names the missing or surplus part.
    pub(super) fn new(task: &PalletizeTask, cell: &Cell) -> Result<Self, SetupError> {
        let arm = suction_arm(cell)?;
        let supply = cell.conveyor.as_ref().and_then(|c| c.supply.as_ref());
        let kind = supply.map(|s| s.objects.as_str()).unwrap_or_default();
        let bins = bins(cell, kind);
        let slots = slots(task);
        let wanted = cell.bins.min(bins.len());
        // More bins than places: the job could not end.
        if wanted == 0 || wanted > slots.len() {
            let places = slots.len();
            return Err(SetupError::new(
                cell,
                format!(
                    "{wanted} bins for {places} places of the pallet; give the pallet more, or \
                     use --bins"
                ),
            ));
        }
        // From the joints, not from a pose in the file: the two could contradict each other.
        let positions = arm.robot.with_arm_positions(&arm.home);
        let tool = arm.robot.frame_pose(arm.robot.tcp_frame, &positions);
        Ok(Self {
            base: arm.base.translation.vector.xy(),
            home: arm.base * tool.unwrap_or_else(Isometry3::identity),
            home_joints: joints(&arm.home),
            jig: Isometry3::from_parts(
                Translation3::from(task.jig.position_m),
                rotation(task.jig.orientation_wxyz),
            ),
            obstacles: obstacles(cell)?,
            solids: Setup::new(cell, []),
            table: Arc::new(behaviour(task, cell)?),
            sequences: WorkKind::ALL.map(|kind| Sequence::new(task, kind)),
            task: task.clone(),
            bins,
            wanted,
            slots,
        })
    }

    /// Name of a bin, by its index in `bins`.
    pub(super) fn name(&self, bin: usize) -> &str {
        self.bins.get(bin).map_or("?", |b| b.name.as_str())
    }

    /// The steps of `kind`.
    pub(super) fn sequence(&self, kind: WorkKind) -> &Sequence {
        let [pick, pick_flipped, flip, place, from_belt, from_home] = &self.sequences;
        match kind {
            WorkKind::Pick => pick,
            WorkKind::PickFlipped => pick_flipped,
            WorkKind::Flip => flip,
            WorkKind::Place => place,
            WorkKind::PlaceFromBelt => from_belt,
            WorkKind::PlaceFromHome => from_home,
        }
    }
}

/// `positions` as a message has them: with zeros for joints that the arm does not have (rad).
pub(super) fn joints(positions: &[f64]) -> [f64; MAX_JOINTS] {
    let mut all = [0.0; MAX_JOINTS];
    for (joint, position) in all.iter_mut().zip(positions) {
        *joint = *position;
    }
    all
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
    // A quarter turn about z: the long sides of bins on the pallet are along y.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let turn = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(h, 0.0, 0.0, h));
    let row = |x: f64| {
        let at =
            move |y: &f64| Isometry3::from_parts(Translation3::new(x, *y, task.slot_z_m), turn);
        task.slot_y_m.iter().map(at)
    };
    task.slot_x_m.iter().copied().flat_map(row).collect()
}

fn obstacles(cell: &Cell) -> Result<ObstacleBits, SetupError> {
    // Fixtures are found by name, so a missing one is refused: its bit would be zero and the
    // arm would pass through its place without notice.
    let bit = |name: &str| match obstacle_bits(cell, |known| known == name) {
        0 => Err(SetupError::new(
            cell,
            format!("this job needs a [[fixture]] '{name}' with obstacle = true"),
        )),
        bit => Ok(bit),
    };
    Ok(ObstacleBits {
        flip_sphere: bit("flip_sphere")?,
        between: bit("navigation_dome")? | bit("navigation_barrier")?,
        flip_barrier: bit("flip_barrier")?,
    })
}

fn behaviour(task: &PalletizeTask, cell: &Cell) -> Result<Table, SetupError> {
    let file = &task.behaviour;
    let text = behaviour_text(cell, file)?;
    let table = Definition::load(&cell.name_of(file), &text, &table::vocabulary())
        .map_err(|problems| SetupError::in_file(problems.to_string()))?;
    // States may be added in the file, but these are the ones that the policy acts on.
    let mut needed = table::State::NAMES.iter();
    match needed.find(|name| table.state(name).is_none()) {
        Some(name) => Err(SetupError::new(
            cell,
            format!("{file} has no state '{name}'; this job needs it"),
        )),
        None => Ok(table),
    }
}
