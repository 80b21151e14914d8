//! `[task]` with `kind = "palletize"`.

use std::collections::BTreeMap;

use cell_model::check::MAX_COORDINATE_M;
use schemars::JsonSchema;
use serde::Deserialize;

/// Largest number of places on a pallet: each needs a bin, which is an object of the cell.
pub(super) const MAX_SLOTS: usize = ipc_types::MAX_OBJECTS;

/// Bins off a conveyor onto a pallet, the upside-down ones over the flip jig.
///
/// Positions and directions are those of the world frame. Targets of the tool
/// are those of its TCP, whose x axis is the direction of approach.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PalletizeTask {
    /// File in `cells/` with the rows of the machine.
    pub behaviour: String,
    /// Centres of the places on the pallet, along x, in the order in which they
    /// are filled (m); for each of them all of `slot_y_m`.
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub slot_x_m: Vec<f64>,
    /// The same along y (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub slot_y_m: Vec<f64>,
    /// Height of the centre of a bin on the pallet (m).
    #[schemars(range(min = -5.0, max = 5.0))]
    pub slot_z_m: f64,
    /// A bin nearer than this to a place, in the plane and in height, is in it
    /// (m).
    #[schemars(range(min = 1.0e-3, max = 0.5))]
    pub slot_tolerance_m: f64,
    /// Where bins are taken off the belt: lower and upper bound along x (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub belt_x_m: [f64; 2],
    /// The same along y (m). A bin between its end and this is there to be
    /// taken; a bin beyond is on its way.
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub belt_y_m: [f64; 2],
    /// The belt stops with a bin short of this (m).
    #[schemars(range(min = -5.0, max = 5.0))]
    pub belt_stop_y_m: f64,
    /// A straight line from the arm's base through this point parts the side of
    /// belt and jig from that of the pallet, x and y (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub side_m: [f64; 2],
    /// Failures of one bin in a row before the job is given up.
    #[schemars(range(min = 1, max = 1000))]
    pub max_attempts: u32,
    /// A target that is not reached within this counts as such a failure (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub reach_timeout_s: f64,
    /// Suction that holds nothing within this is switched off again (s).
    #[schemars(range(min = 0.02, max = 60.0))]
    pub attach_timeout_s: f64,
    /// Time between two requests for a bin at least (s).
    #[schemars(range(min = 0.0, max = 600.0))]
    pub supply_interval_s: f64,
    /// Within this of its place, in the plane, a bin creeps towards it (m),
    #[schemars(range(min = 0.0, max = 0.5))]
    pub creep_m: f64,
    /// by this part of the error in each decision.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub creep_gain: f64,
    /// Where bins are turned over.
    pub jig: JigTable,
    /// Sequences of work on a bin: names of `steps`.
    pub sequences: SequenceTable,
    /// The steps by name.
    pub steps: BTreeMap<String, StepTable>,
}

/// `[task.jig]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JigTable {
    /// Where the cup lets go of the bin (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub position_m: [f64; 3],
    /// Orientation of the tool there, w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Middle of the jig, x and y (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub middle_m: [f64; 2],
    /// A bin whose centre is this near to the middle, in the plane, is in the jig
    /// (m).
    #[schemars(range(min = 1.0e-2, max = 1.0))]
    pub radius_m: f64,
    /// A tool that near is at work at the jig below this height (m).
    #[schemars(range(min = -5.0, max = 5.0))]
    pub below_z_m: f64,
}

/// `[task.sequences]`: steps from the first to the last.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SequenceTable {
    /// Take a bin that opens upwards.
    pub pick: Vec<String>,
    /// Take a bin that is upside down.
    pub pick_flipped: Vec<String>,
    /// Bring a bin to the jig and let it go.
    pub flip: Vec<String>,
    /// Set a bin down from where it is.
    pub place: Vec<String>,
    /// Set a bin down that comes from the belt.
    pub place_from_belt: Vec<String>,
    /// Set a bin down that was not brought to its place before.
    pub place_from_home: Vec<String>,
}

/// `[task.steps.NAME]`: it ends with its time, its motion, or the suction.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepTable {
    /// Shown as the phase; the name of the step where it is missing.
    #[serde(default)]
    pub phase: Option<String>,
    /// Where the arm goes; without, it stays with the target it has.
    #[serde(default)]
    pub go: Option<GoTable>,
    /// The step lasts this long, reached or not (s).
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub wait_s: Option<f64>,
    /// The belt stops at the end of this step; it is stopped in all others.
    #[serde(default)]
    pub stops_belt: bool,
    /// Suction is switched, and the step lasts until a bin is attached, or free.
    #[serde(default)]
    pub suction: Option<Suction>,
}

/// A motion.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GoTable {
    /// Where to.
    pub to: Target,
    /// The TCP is there when nearer than this; near its height for `up` (m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub tolerance_m: f64,
    /// And its axes within this; any without (rad).
    #[serde(default)]
    #[schemars(range(min = 1.0e-3, max = 3.2))]
    pub angle_tolerance_rad: Option<f64>,
    /// Joint positions to lean to; those of the rest pose without (rad).
    #[serde(default)]
    #[schemars(inner(range(min = -7.0, max = 7.0)))]
    pub posture: Option<[f64; 6]>,
    /// It leans to the joint positions that it has at the start.
    #[serde(default)]
    pub keeps_posture: bool,
    /// Direction of the approach corridor times its length, world frame (m).
    #[serde(default)]
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub std_dev_m: f64,
}

/// Where the TCP goes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Target {
    /// To the floor of the bin, from the inside or the outside.
    Bin {
        /// Gap between cup and floor (m).
        #[schemars(range(min = 0.0, max = 0.1))]
        gap_m: f64,
        /// Length of the approach corridor along the tool (m).
        #[schemars(range(min = 0.0, max = 1.0))]
        approach_m: f64,
    },
    /// Straight up from the target before.
    Up {
        /// How far (m).
        #[schemars(range(min = 0.0, max = 1.0))]
        by_m: f64,
        /// The target stays this far ahead of the TCP: near its target the tool keeps
        /// its orientation, far from it a bin would swing (m).
        #[schemars(range(min = 1.0e-3, max = 1.0))]
        lead_m: f64,
    },
    /// The arm's rest pose.
    Home {
        /// Joint by joint: with the tool pointing up, or where the arm may be wound up.
        by_joints: bool,
    },
    /// Where the cup lets go of a bin in the jig.
    Jig {},
    /// Back along the tool from the target before, in a corridor.
    Back {
        /// How far (m).
        #[schemars(range(min = 0.0, max = 1.0))]
        by_m: f64,
        /// And by this besides, world frame (m).
        #[schemars(inner(range(min = -1.0, max = 1.0)))]
        aside_m: [f64; 3],
    },
    /// A point on the way, with the orientation of the target before, or of the place.
    Via {
        /// Where (m).
        #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
        position_m: [f64; 3],
    },
    /// The bin's place on the pallet.
    Slot {
        /// Gap between bin and pallet (m).
        #[schemars(range(min = 0.0, max = 0.1))]
        gap_m: f64,
    },
}

/// What suction is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Suction {
    /// To attach the bin.
    On,
    /// To let it go.
    Off,
}
