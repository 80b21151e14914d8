//! `[task]` with `kind = "palletize"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Most places a pallet may have: what a decision can name.
const MAX_SLOTS: usize = 48;

/// Bins off a conveyor onto a pallet, the upside-down ones over the flip jig.
///
/// Positions and directions are those of the world frame. Targets of the tool
/// are those of its TCP, whose x axis is the direction of approach.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PalletizeTask {
    /// File in `cells/` that describes the behaviour.
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
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub max_attempts: u32,
    /// A target that is not reached within this counts as such a failure (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub reach_timeout_s: f64,
    /// Time between two requests for a bin at least (s).
    #[schemars(range(min = 0.0, max = 600.0))]
    pub supply_interval_s: f64,
    /// Taking a bin.
    pub pick: PickNumbers,
    /// Turning one over.
    pub flip: FlipNumbers,
    /// Setting one down.
    pub place: PlaceNumbers,
    /// The way over the arm's rest pose.
    pub home: HomeNumbers,
}

/// `[task.pick]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PickNumbers {
    /// The belt runs on for this long before the arm moves (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub wait_s: f64,
    /// The arm waits this long at the bin before suction is switched on (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub settle_s: f64,
    /// Gap between cup and bin (m).
    #[schemars(range(min = 0.0, max = 0.1))]
    pub gap_m: f64,
    /// Length of the approach to a bin that opens upwards (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub approach_m: f64,
    /// Length of the approach to a bin that lies upside down (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flip_approach_m: f64,
    /// Width of the approach corridor (standard deviation, m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub std_dev_m: f64,
    /// The cup is there when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub tolerance_m: f64,
    /// And its axes within this (rad).
    #[schemars(range(min = 1.0e-3, max = 3.2))]
    pub angle_tolerance_rad: f64,
    /// Suction that holds nothing within this is switched off again (s).
    #[schemars(range(min = 0.02, max = 60.0))]
    pub attach_timeout_s: f64,
    /// How high a bin that opens upwards is lifted before it is carried (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lift_m: f64,
    /// The target stays this far ahead of the tool meanwhile (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub lift_lead_m: f64,
    /// It is lifted when this near (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub lift_tolerance_m: f64,
    /// How far up the arm is sent with one that lies upside down (m),
    #[schemars(range(min = 0.0, max = 1.0))]
    pub flip_lift_m: f64,
    /// and for how long (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub flip_lift_s: f64,
    /// Joint positions to lean to (rad).
    #[schemars(inner(range(min = -7.0, max = 7.0)))]
    pub posture: [f64; 6],
}

/// `[task.flip]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlipNumbers {
    /// Where the cup lets go of the bin (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub position_m: [f64; 3],
    /// Orientation of the tool there, w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Joint positions to lean to (rad).
    #[schemars(inner(range(min = -7.0, max = 7.0)))]
    pub posture: [f64; 6],
    /// Direction of the approach times its length (m).
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub std_dev_m: f64,
    /// The cup is there when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub tolerance_m: f64,
    /// After suction was switched off the arm waits this long (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub wait_s: f64,
    /// The tool backs off along its axis by this (m),
    #[schemars(range(min = 0.0, max = 1.0))]
    pub retreat_m: f64,
    /// and by this besides (m).
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub retreat_aside_m: [f64; 3],
    /// Width of that corridor (standard deviation, m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub retreat_std_dev_m: f64,
    /// It has backed off when this near (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub retreat_tolerance_m: f64,
    /// Then it goes here, beside the jig and above it (m),
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub leave_m: [f64; 3],
    /// this near (m), before it is turned.
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub leave_tolerance_m: f64,
    /// A bin whose centre is this near to `jig_m`, in the plane, lies in the jig
    /// (m).
    #[schemars(range(min = 1.0e-2, max = 1.0))]
    pub jig_radius_m: f64,
    /// Middle of the jig, x and y (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub jig_m: [f64; 2],
}

/// `[task.place]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceNumbers {
    /// Length of the approach, from above (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub approach_m: f64,
    /// Width of the approach corridor (standard deviation, m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub std_dev_m: f64,
    /// A bin from the belt is first carried here, out of the way of the arm's own
    /// base (m),
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub swing_m: [f64; 3],
    /// this near (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub swing_tolerance_m: f64,
    /// The bin is there when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub tolerance_m: f64,
    /// Gap between bin and pallet when it is let go (m).
    #[schemars(range(min = 0.0, max = 0.1))]
    pub gap_m: f64,
    /// The arm waits this long before it lets go (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub settle_s: f64,
    /// Within this of its place, in the plane, the bin creeps towards it (m),
    #[schemars(range(min = 0.0, max = 0.5))]
    pub creep_m: f64,
    /// by this part of the error in each decision.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub creep_gain: f64,
    /// How far up the arm is sent afterwards (m),
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lift_m: f64,
    /// and for how long (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub lift_s: f64,
}

/// `[task.home]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HomeNumbers {
    /// Direction of the approach times its length (m).
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub std_dev_m: f64,
    /// The tool is there when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 0.5))]
    pub tolerance_m: f64,
    /// And its axes within this (rad).
    #[schemars(range(min = 1.0e-3, max = 3.2))]
    pub angle_tolerance_rad: f64,
}

impl Settings for PalletizeTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check::behaviour(at, &self.behaviour)?;
        if cell.conveyor.as_ref().is_none_or(|c| c.supply.is_none()) {
            let allowed = "this job needs a [conveyor] with a [conveyor.supply]";
            return Err(at.refuse("task.kind", "'palletize'", allowed));
        }
        let slots = self.slot_x_m.len() * self.slot_y_m.len();
        if slots == 0 || slots > MAX_SLOTS {
            let allowed = format!("1 to {MAX_SLOTS} places are allowed");
            return Err(at.refuse("task.slot_x_m", format!("{slots} places"), allowed));
        }
        let key = "task.flip.orientation_wxyz";
        check::unit_quaternion(at, key, &self.flip.orientation_wxyz, 1.0e-4)
    }
}
