//! Settings and memory of the job.

use cell_model::{Cell, Shape};
use ipc_types::Pose;
use nalgebra::Vector3;
use robocell_skills::matrix;
use robocell_skills::setup::{obstacle_bits, suction_arm};
use robocell_skills::{KeptPose, named, pose};
use robocell_task::{PolicyTime, SetupError};
use serde::{Deserialize, Serialize};

use super::columns::{Columns, Order};
use super::numbers::BinStackTask;

/// One decision.
pub(super) type Turn<'t> = matrix::Turn<'t, BinStack>;

/// Prefix of the names of the fixtures of the flipping station.
const HOLDER: &str = "holder";

named! {
    /// The states.
    pub(super) enum State {
        Standby = "STANDBY",
        Picking = "PICKING",
        Attach = "ATTACH",
        Placing = "PLACING",
        Detach = "DETACH",
        Flipping = "FLIPPING",
    }
}

/// The settings of the cell file, and the values derived from them.
#[derive(Debug)]
pub(super) struct BinStack {
    pub(super) task: BinStackTask,
    pub(super) columns: Columns,
    /// Objects that are bins, by index in the cell file.
    pub(super) bins: Vec<usize>,
    /// Objects of the cell.
    pub(super) objects: usize,
    /// Number of bins that have to be stacked.
    pub(super) wanted: usize,
    /// Height of a bin (m).
    pub(super) height_m: f64,
    /// Thickness of its floor (m).
    pub(super) wall_m: f64,
    /// Index of the sensor at the end of the belt.
    pub(super) sensor: usize,
    /// Bits of all obstacles except those of the flipping station.
    pub(super) without_holder: u64,
    /// Limits of the arm's joints (rad).
    pub(super) joints: Vec<(f64, f64)>,
    /// Base of the arm, world frame (m).
    pub(super) base: Vector3<f64>,
    /// Pose of the TCP at rest.
    pub(super) rest: Pose,
    pub(super) seed: u64,
}

impl BinStack {
    pub(super) fn new(task: &BinStackTask, cell: &Cell) -> Result<Self, SetupError> {
        let arm = suction_arm(cell)?;
        let objects = cell.objects.iter().enumerate();
        let bins = objects.filter(|(_, object)| object.kind == task.bins);
        let bins: Vec<usize> = bins.map(|(index, _)| index).collect();
        let first = bins.first().and_then(|bin| cell.objects.get(*bin));
        // The shape is taken from the first bin: all bins of a table have the same.
        let Some(Shape::Bin { size_m, wall_m }) = first.map(|object| &object.shape) else {
            let problem = "task.bins names nothing with the shape of a bin";
            return Err(SetupError::new(cell, problem));
        };
        let sensor = cell.sensors.iter().position(|s| s.name == task.sensor);
        Ok(Self {
            columns: Columns::new(task.stack.clone(), size_m[2]),
            objects: cell.objects.len(),
            wanted: bins.len().min(cell.bins),
            bins,
            height_m: size_m[2],
            wall_m: *wall_m,
            sensor: sensor
                .ok_or_else(|| SetupError::new(cell, "task.sensor names no [[sensor]]"))?,
            without_holder: !obstacle_bits(cell, |name| name.starts_with(HOLDER)),
            joints: arm.robot.arm_specs().map(|j| (j.lower, j.upper)).collect(),
            base: arm.base.translation.vector,
            rest: pose::with_unit_quaternion(&Pose {
                position: task.rest_position_m,
                orientation_wxyz: task.rest_orientation_wxyz,
            }),
            seed: cell.seed,
            task: task.clone(),
        })
    }
}

/// Numbers of the behaviour file.
pub(super) struct BinStackNumbers {
    /// The order in which columns are filled.
    pub(super) order: Order,
    /// Cosine of the angle within which a bin is flat, or straight in its column.
    pub(super) straight: f64,
    /// A bin farther than this from the arm's axis cannot be picked (m).
    pub(super) reach_m: f64,
    /// Two bins nearer than this in the plane may be one on the other (m).
    pub(super) beside_m: f64,
    /// A bin higher than this above another one is on top of it (m).
    pub(super) on_top_m: f64,
    /// A bin nearer than this to the middle of the holder is in it, or over it (m).
    pub(super) holder_m: f64,
    /// A joint nearer than this to its limit is caught (rad).
    pub(super) joint_margin_rad: f64,
    /// A bin is lifted by this at least (m).
    pub(super) least_lift_m: f64,
    /// Between places whose directions from the arm differ by more than this the route leads
    /// around the arm (rad).
    pub(super) around_rad: f64,
    /// Time from the start to the first request for a bin.
    pub(super) first_bin: PolicyTime,
    /// Time after which a request without a bin is repeated.
    pub(super) ask_again: PolicyTime,
    /// Time without anything to pick and without a bin on its way, after which bins that are
    /// not in place are given up.
    pub(super) lost_after: PolicyTime,
}

/// Requests to the conveyor so far; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SupplyMemory {
    /// Time of the next request for a bin.
    pub(super) next_at: Option<PolicyTime>,
    /// Time of the last request.
    pub(super) asked_at: Option<PolicyTime>,
    /// Picks from the belt so far; each has its own random delay.
    pub(super) picks: u64,
    /// Time since which nothing can be picked while bins are missing.
    pub(super) missing_since: Option<PolicyTime>,
}

/// The memory of the job; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The bin in progress, by its index in the cell file.
    pub(super) bin: Option<usize>,
    /// The bin has to be turned over before it can be placed.
    pub(super) turning: bool,
    /// Pose of the bin in the frame of the TCP, as it was gripped.
    pub(super) in_hand: Option<KeptPose>,
    /// Its slot: column in the order of filling, level.
    pub(super) slot: Option<(usize, usize)>,
    /// The bin in the gripper has no free slot.
    pub(super) waits: bool,
    /// Suction was switched off to release the bin.
    pub(super) opening: bool,
    /// The bin that was released over its slot and not checked yet.
    pub(super) set_down: Option<usize>,
    /// Number of states in a row that lasted too long.
    pub(super) stuck: u32,
    pub(super) supply: SupplyMemory,
}

impl Memory {
    /// Forgets the bin in progress.
    pub(super) fn forget_bin(&mut self) {
        self.bin = None;
        self.turning = false;
        self.in_hand = None;
        self.slot = None;
        self.waits = false;
        self.opening = false;
    }
}
