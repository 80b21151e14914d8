//! `[task]` with `kind = "stack"`.

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check::{fingers_grip, object_names, order, tool_gets_to, within_reach};

/// Stack cubes on one spot in a given order.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StackTask {
    /// Objects from bottom to top.
    pub order: Vec<String>,
    /// Centre of the stack on the table, x and y in the world frame (m).
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub stack_position_m: [f64; 2],
    /// Height of the centre of the lowest object (m).
    #[schemars(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M))]
    pub base_height_m: f64,
    /// Height of one layer (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub layer_height_m: f64,
    /// Height above pick and place at which the tool travels (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clearance_m: f64,
    /// Offset of the TCP from the centre of a grasped object, world frame (m).
    #[schemars(inner(range(min = -0.5, max = 0.5)))]
    pub grasp_offset_m: [f64; 3],
    /// An object nearer than this to its goal is in place (m, strictly less).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub goal_tolerance_m: f64,
    /// The TCP is at a travel target when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub travel_tolerance_m: f64,
    /// The TCP is at a pick or place target when nearer than this (m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub precise_tolerance_m: f64,
    /// The TCP's angle to the target counts as reached below this (rad).
    #[schemars(range(min = 1.0e-4, max = 3.2))]
    pub orientation_tolerance_rad: f64,
    /// The gripper is open when within this of the open width (m).
    #[schemars(range(min = 1.0e-5, max = 0.5))]
    pub gripper_tolerance_m: f64,
    /// A cube that moved further than this in the plane while it is picked
    /// restarts the pick-up (m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub move_tolerance_m: f64,
    /// A held cube further than this from the TCP was lost (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub drop_distance_m: f64,
    /// Finger distance of an open gripper (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub open_width_m: f64,
    /// Force per finger (N).
    #[schemars(range(min = 0.1, max = 1.0e4))]
    pub grip_force_n: f64,
    /// A phase lasts at least this long (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub min_phase_s: f64,
    /// A target has to be reached for this long (s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub settle_s: f64,
    /// A long phase (pre-grasp, retract) advances after this at the latest (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub timeout_s: f64,
    /// A short phase (approach, lift, transport, lower) likewise (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub short_timeout_s: f64,
    /// A gripper that does not open within this is blocked (s).
    #[schemars(range(min = 0.1, max = 600.0))]
    pub release_timeout_s: f64,
    /// Pick-ups of one cube that may fail in a row before the run is given up.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub max_attempts: u32,
    /// A cube further than this from the arm's base, in the plane, is out of
    /// reach (m).
    #[schemars(range(min = 1.0e-2, max = MAX_COORDINATE_M))]
    pub reach_m: f64,
}

impl Settings for StackTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        order(at, "task.order", &self.order, &object_names(cell))?;
        let key = "task.stack_position_m";
        within_reach(
            at,
            key,
            cell.arms.first(),
            self.stack_position_m,
            self.reach_m,
        )?;
        fingers_grip(at, cell, 0, &self.order)?;
        let [x, y] = self.stack_position_m;
        // The lowest and the highest layer: those between are reached if both are.
        let layers = [0, self.order.len() - 1];
        let points = layers.map(|layer| {
            let height = self.base_height_m + self.layer_height_m * layer as f64;
            let [dx, dy, dz] = self.grasp_offset_m;
            [x + dx, y + dy, height + dz]
        });
        tool_gets_to(at, key, cell.arms.first(), points)
    }

    fn grip_force_n(&self, _cell: &Cell) -> f64 {
        self.grip_force_n
    }
}
