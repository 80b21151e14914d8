//! `[task]` with `kind = "stack"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check::{object_names, order};

/// Stack cubes on one spot in a given order.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StackTask {
    /// Objects from bottom to top.
    pub order: Vec<String>,
    /// Centre of the stack on the table, x and y in the world frame (m).
    pub stack_position_m: [f64; 2],
    /// Height of the centre of the lowest object (m).
    pub base_height_m: f64,
    /// Height of one layer (m).
    pub layer_height_m: f64,
    /// Height above pick and place at which the tool travels (m).
    pub clearance_m: f64,
    /// Offset of the TCP from the centre of a grasped object, world frame (m).
    pub grasp_offset_m: [f64; 3],
    /// An object nearer than this to its goal is in place (m, strictly less).
    pub goal_tolerance_m: f64,
    /// The TCP is at a travel target when nearer than this (m).
    pub travel_tolerance_m: f64,
    /// The TCP is at a pick or place target when nearer than this (m).
    pub precise_tolerance_m: f64,
    /// The TCP's angle to the target counts as reached below this (rad).
    pub orientation_tolerance_rad: f64,
    /// The gripper is open when within this of the open width (m).
    pub gripper_tolerance_m: f64,
    /// A cube that moved further than this in the plane while it is picked
    /// restarts the pick-up (m).
    pub move_tolerance_m: f64,
    /// A held cube further than this from the TCP was lost (m).
    pub drop_distance_m: f64,
    /// Finger distance of an open gripper (m).
    pub open_width_m: f64,
    /// Finger distance commanded to close; force stops it earlier (m).
    pub closed_width_m: f64,
    /// Force per finger (N).
    pub grip_force_n: f64,
    /// A phase lasts at least this long (s).
    pub min_phase_s: f64,
    /// A target has to be reached for this long (s).
    pub settle_s: f64,
    /// A long phase (pre-grasp, retract) advances after this at the latest (s).
    pub timeout_s: f64,
    /// A short phase (approach, lift, transport, lower) likewise (s).
    pub short_timeout_s: f64,
    /// A gripper that does not open within this is blocked (s).
    pub release_timeout_s: f64,
    /// Pick-ups of one cube that may fail in a row before the run is given up.
    pub max_attempts: u32,
    /// A cube further than this from the arm's base, in the plane, is out of
    /// reach (m).
    pub reach_m: f64,
    /// As in the source, the behaviour tree takes a cube for held until the
    /// tool is up again; then a good place can look like a drop.
    #[serde(default)]
    pub holds_until_retracted: bool,
}

impl Settings for StackTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        let names = object_names(cell);
        order(at, "task.order", &self.order, &names)?;
        at.numbers(
            "task.stack_position_m",
            &self.stack_position_m,
            -MAX_COORDINATE_M,
            MAX_COORDINATE_M,
        )?;
        at.numbers("task.grasp_offset_m", &self.grasp_offset_m, -0.5, 0.5)?;
        at.number(
            "task.base_height_m",
            self.base_height_m,
            -MAX_COORDINATE_M,
            MAX_COORDINATE_M,
        )?;
        stack_numbers(at, self)
    }

    fn grip_force_n(&self, _cell: &Cell) -> f64 {
        self.grip_force_n
    }
}

fn stack_numbers(at: &Checker<'_>, task: &StackTask) -> Result<(), ModelError> {
    let ranges = [
        ("layer_height_m", task.layer_height_m, 1.0e-3, 1.0),
        ("clearance_m", task.clearance_m, 0.0, 1.0),
        ("goal_tolerance_m", task.goal_tolerance_m, 1.0e-4, 1.0),
        ("travel_tolerance_m", task.travel_tolerance_m, 1.0e-4, 1.0),
        ("precise_tolerance_m", task.precise_tolerance_m, 1.0e-4, 1.0),
        (
            "orientation_tolerance_rad",
            task.orientation_tolerance_rad,
            1.0e-4,
            3.2,
        ),
        ("gripper_tolerance_m", task.gripper_tolerance_m, 1.0e-5, 0.5),
        ("move_tolerance_m", task.move_tolerance_m, 1.0e-4, 1.0),
        ("drop_distance_m", task.drop_distance_m, 1.0e-3, 1.0),
        ("open_width_m", task.open_width_m, 1.0e-3, 1.0),
        (
            "closed_width_m",
            task.closed_width_m,
            0.0,
            task.open_width_m,
        ),
        ("grip_force_n", task.grip_force_n, 0.1, 1.0e4),
        ("min_phase_s", task.min_phase_s, 0.0, 60.0),
        ("settle_s", task.settle_s, 0.0, 60.0),
        ("timeout_s", task.timeout_s, 0.1, 600.0),
        ("short_timeout_s", task.short_timeout_s, 0.1, 600.0),
        ("release_timeout_s", task.release_timeout_s, 0.1, 600.0),
        ("max_attempts", f64::from(task.max_attempts), 1.0, 1000.0),
        ("reach_m", task.reach_m, 1.0e-2, MAX_COORDINATE_M),
    ];
    at.ranges("task", &ranges)
}
