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
    pub slot_x_m: Vec<f64>,
    /// The same along y (m).
    pub slot_y_m: Vec<f64>,
    /// Height of the centre of a bin on the pallet (m).
    pub slot_z_m: f64,
    /// A bin nearer than this to a place, in the plane and in height, is in it
    /// (m).
    pub slot_tolerance_m: f64,
    /// Where bins are taken off the belt: lower and upper bound along x (m).
    pub belt_x_m: [f64; 2],
    /// The same along y (m). A bin between its end and this is there to be
    /// taken; a bin beyond is on its way.
    pub belt_y_m: [f64; 2],
    /// The belt stops with a bin short of this (m).
    pub belt_stop_y_m: f64,
    /// A straight line from the arm's base through this point parts the side of
    /// belt and jig from that of the pallet, x and y (m).
    pub side_m: [f64; 2],
    /// Failures of one bin in a row before the job is given up.
    pub max_attempts: u32,
    /// A target that is not reached within this counts as such a failure (s).
    pub reach_timeout_s: f64,
    /// Time between two requests for a bin at least (s).
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
    pub wait_s: f64,
    /// The arm waits this long at the bin before suction is switched on (s).
    pub settle_s: f64,
    /// Gap between cup and bin (m).
    pub gap_m: f64,
    /// Length of the approach to a bin that opens upwards (m).
    pub approach_m: f64,
    /// Length of the approach to a bin that lies upside down (m).
    pub flip_approach_m: f64,
    /// Width of the approach corridor (standard deviation, m).
    pub std_dev_m: f64,
    /// The cup is there when nearer than this (m).
    pub tolerance_m: f64,
    /// And its axes within this (rad).
    pub angle_tolerance_rad: f64,
    /// Suction that holds nothing within this is switched off again (s).
    pub attach_timeout_s: f64,
    /// How high a bin that opens upwards is lifted before it is carried (m).
    pub lift_m: f64,
    /// The target stays this far ahead of the tool meanwhile (m).
    pub lift_lead_m: f64,
    /// It is lifted when this near (m).
    pub lift_tolerance_m: f64,
    /// How far up the arm is sent with one that lies upside down (m),
    pub flip_lift_m: f64,
    /// and for how long (s).
    pub flip_lift_s: f64,
    /// Joint positions to lean to (rad).
    pub posture: [f64; 6],
}

/// `[task.flip]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlipNumbers {
    /// Where the cup lets go of the bin (m).
    pub position_m: [f64; 3],
    /// Orientation of the tool there, w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Joint positions to lean to (rad).
    pub posture: [f64; 6],
    /// Direction of the approach times its length (m).
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    pub std_dev_m: f64,
    /// The cup is there when nearer than this (m).
    pub tolerance_m: f64,
    /// After suction was switched off the arm waits this long (s).
    pub wait_s: f64,
    /// The tool backs off along its axis by this (m),
    pub retreat_m: f64,
    /// and by this besides (m).
    pub retreat_aside_m: [f64; 3],
    /// Width of that corridor (standard deviation, m).
    pub retreat_std_dev_m: f64,
    /// It has backed off when this near (m).
    pub retreat_tolerance_m: f64,
    /// Then it goes here, beside the jig and above it (m),
    pub leave_m: [f64; 3],
    /// this near (m), before it is turned.
    pub leave_tolerance_m: f64,
    /// A bin whose centre is this near to `jig_m`, in the plane, lies in the jig
    /// (m).
    pub jig_radius_m: f64,
    /// Middle of the jig, x and y (m).
    pub jig_m: [f64; 2],
}

/// `[task.place]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceNumbers {
    /// Length of the approach, from above (m).
    pub approach_m: f64,
    /// Width of the approach corridor (standard deviation, m).
    pub std_dev_m: f64,
    /// A bin from the belt is first carried here, out of the way of the arm's own
    /// base (m),
    pub swing_m: [f64; 3],
    /// this near (m).
    pub swing_tolerance_m: f64,
    /// The bin is there when nearer than this (m).
    pub tolerance_m: f64,
    /// Gap between bin and pallet when it is let go (m).
    pub gap_m: f64,
    /// The arm waits this long before it lets go (s).
    pub settle_s: f64,
    /// Within this of its place, in the plane, the bin creeps towards it (m),
    pub creep_m: f64,
    /// by this part of the error in each decision.
    pub creep_gain: f64,
    /// How far up the arm is sent afterwards (m),
    pub lift_m: f64,
    /// and for how long (s).
    pub lift_s: f64,
}

/// `[task.home]`
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HomeNumbers {
    /// Direction of the approach times its length (m).
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m).
    pub std_dev_m: f64,
    /// The tool is there when nearer than this (m).
    pub tolerance_m: f64,
    /// And its axes within this (rad).
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
        palletize_places(at, self)?;
        at.ranges("task", &self.ranges())?;
        at.ranges("task.pick", &self.pick.ranges())?;
        at.ranges("task.flip", &self.flip.ranges())?;
        at.ranges("task.place", &self.place.ranges())?;
        at.ranges("task.home", &self.home.ranges())
    }
}

fn palletize_places(at: &Checker<'_>, task: &PalletizeTask) -> Result<(), ModelError> {
    let far = MAX_COORDINATE_M;
    let flip = &task.flip;
    at.numbers("task.slot_x_m", &task.slot_x_m, -far, far)?;
    at.numbers("task.slot_y_m", &task.slot_y_m, -far, far)?;
    at.numbers("task.belt_x_m", &task.belt_x_m, -far, far)?;
    at.numbers("task.belt_y_m", &task.belt_y_m, -far, far)?;
    at.numbers("task.side_m", &task.side_m, -far, far)?;
    at.numbers("task.pick.posture", &task.pick.posture, -7.0, 7.0)?;
    at.numbers("task.flip.posture", &flip.posture, -7.0, 7.0)?;
    at.position("task.flip.position_m", &flip.position_m)?;
    at.position("task.place.swing_m", &task.place.swing_m)?;
    at.position("task.flip.leave_m", &flip.leave_m)?;
    at.numbers("task.flip.approach_m", &flip.approach_m, -1.0, 1.0)?;
    at.numbers(
        "task.flip.retreat_aside_m",
        &flip.retreat_aside_m,
        -1.0,
        1.0,
    )?;
    at.numbers("task.flip.jig_m", &flip.jig_m, -far, far)?;
    at.numbers("task.home.approach_m", &task.home.approach_m, -1.0, 1.0)?;
    let key = "task.flip.orientation_wxyz";
    check::unit_quaternion(at, key, &flip.orientation_wxyz, 1.0e-4)
}

/// Key, value, smallest and largest allowed.
type Range = (&'static str, f64, f64, f64);

impl PalletizeTask {
    fn ranges(&self) -> [Range; 6] {
        [
            ("slot_z_m", self.slot_z_m, -5.0, 5.0),
            ("belt_stop_y_m", self.belt_stop_y_m, -5.0, 5.0),
            ("slot_tolerance_m", self.slot_tolerance_m, 1.0e-3, 0.5),
            ("max_attempts", f64::from(self.max_attempts), 1.0, 1000.0),
            ("reach_timeout_s", self.reach_timeout_s, 0.1, 600.0),
            ("supply_interval_s", self.supply_interval_s, 0.0, 600.0),
        ]
    }
}

impl PickNumbers {
    fn ranges(&self) -> [Range; 14] {
        [
            ("wait_s", self.wait_s, 0.0, 60.0),
            ("settle_s", self.settle_s, 0.0, 60.0),
            ("gap_m", self.gap_m, 0.0, 0.1),
            ("approach_m", self.approach_m, 0.0, 1.0),
            ("flip_approach_m", self.flip_approach_m, 0.0, 1.0),
            ("std_dev_m", self.std_dev_m, 1.0e-4, 1.0),
            ("tolerance_m", self.tolerance_m, 1.0e-4, 0.5),
            ("angle_tolerance_rad", self.angle_tolerance_rad, 1.0e-3, 3.2),
            ("attach_timeout_s", self.attach_timeout_s, 0.02, 60.0),
            ("lift_m", self.lift_m, 0.0, 1.0),
            ("lift_lead_m", self.lift_lead_m, 1.0e-3, 1.0),
            ("lift_tolerance_m", self.lift_tolerance_m, 1.0e-3, 1.0),
            ("flip_lift_m", self.flip_lift_m, 0.0, 1.0),
            ("flip_lift_s", self.flip_lift_s, 0.0, 60.0),
        ]
    }
}

impl FlipNumbers {
    fn ranges(&self) -> [Range; 8] {
        [
            ("std_dev_m", self.std_dev_m, 1.0e-4, 1.0),
            ("tolerance_m", self.tolerance_m, 1.0e-4, 0.5),
            ("wait_s", self.wait_s, 0.0, 60.0),
            ("retreat_m", self.retreat_m, 0.0, 1.0),
            ("retreat_std_dev_m", self.retreat_std_dev_m, 1.0e-4, 1.0),
            ("retreat_tolerance_m", self.retreat_tolerance_m, 1.0e-3, 1.0),
            ("leave_tolerance_m", self.leave_tolerance_m, 1.0e-3, 1.0),
            ("jig_radius_m", self.jig_radius_m, 1.0e-2, 1.0),
        ]
    }
}

impl PlaceNumbers {
    fn ranges(&self) -> [Range; 10] {
        [
            ("approach_m", self.approach_m, 0.0, 1.0),
            ("std_dev_m", self.std_dev_m, 1.0e-4, 1.0),
            ("tolerance_m", self.tolerance_m, 1.0e-4, 0.5),
            ("gap_m", self.gap_m, 0.0, 0.1),
            ("settle_s", self.settle_s, 0.0, 60.0),
            ("swing_tolerance_m", self.swing_tolerance_m, 1.0e-3, 1.0),
            ("creep_m", self.creep_m, 0.0, 0.5),
            ("creep_gain", self.creep_gain, 0.0, 1.0),
            ("lift_m", self.lift_m, 0.0, 1.0),
            ("lift_s", self.lift_s, 0.0, 60.0),
        ]
    }
}

impl HomeNumbers {
    fn ranges(&self) -> [Range; 3] {
        [
            ("std_dev_m", self.std_dev_m, 1.0e-4, 1.0),
            ("tolerance_m", self.tolerance_m, 1.0e-4, 0.5),
            ("angle_tolerance_rad", self.angle_tolerance_rad, 1.0e-3, 3.2),
        ]
    }
}
