//! `[task]` of a cell file: the numbers a demo's policies work with.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

pub use crate::task_bin_stack::{BinColumns, BinStackTask, FlippingStation};
pub use crate::task_fill_bin::FillBinTask;
pub use crate::task_palletize::PalletizeTask;

/// Most objects a stack may be made of.
pub const MAX_STACK: usize = 16;

/// The `[task]` table, by its `kind`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum TaskSpec {
    /// Stack cubes in an order.
    Stack(StackTask),
    /// Take a pyramid apart with several arms, into a stack each.
    Pyramid(PyramidTask),
    /// Follow the operator's target.
    Reach(ReachTask),
    /// Bins off a conveyor onto a pallet.
    Palletize(PalletizeTask),
    /// Fill a bin until the grip breaks.
    FillBin(FillBinTask),
    /// Bins off a conveyor into columns.
    BinStack(BinStackTask),
}

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
    /// makes the pick-up begin again (m).
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

/// Take a pyramid of cubes apart; every arm builds a stack of its own.
///
/// Heights of the tool are those of the TCP, whose frame lies between the pads.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PyramidTask {
    /// Height of the centre of the lowest cube of a stack, world frame (m).
    pub base_height_m: f64,
    /// Height of one layer (m).
    pub layer_height_m: f64,
    /// Cubes in a finished stack of one arm.
    pub required_count: u32,
    /// TCP above the centre of the cube before it is grasped (m).
    pub approach_m: f64,
    /// TCP above the centre of the cube when it is grasped (m).
    pub grasp_m: f64,
    /// TCP height after the lift, world frame (m).
    pub lift_z_m: f64,
    /// TCP above the cube's goal before it is lowered (m).
    pub place_approach_m: f64,
    /// TCP above the cube's goal when it is let go, before the place is
    /// corrected by how the cube lies in the hand (m).
    pub place_m: f64,
    /// TCP above the cube's goal after it was let go (m).
    pub retract_m: f64,
    /// An object nearer than this to its goal, in the plane, is in place (m).
    pub goal_tolerance_m: f64,
    /// Finger distance of an open gripper (m).
    pub open_width_m: f64,
    /// Finger distance commanded to close; force stops it earlier (m).
    pub closed_width_m: f64,
    /// The gripper is open when within this of the open width (m).
    pub gripper_tolerance_m: f64,
    /// Force per finger (N).
    pub grip_force_n: f64,
    /// A cube further than this from the arm's base, in the plane, is out of
    /// reach (m).
    pub reach_m: f64,
    /// What belongs to one arm, by the arm's name: one entry for every arm.
    pub robot: BTreeMap<String, PyramidArm>,
}

/// `[task.robot.NAME]`: the part of one arm.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PyramidArm {
    /// File in `cells/` that describes the behaviour.
    pub behaviour: String,
    /// Blackboard it shares with all arms that name the same one.
    pub board: String,
    /// Centre of the arm's stack on the table, x and y in the world frame (m).
    pub goal_m: [f64; 2],
    /// Turn of the hand about the world's z where it points straight down and
    /// its fingers close along y at zero (rad).
    pub yaw_rad: f64,
    /// Cubes in the order in which this arm tries them.
    pub order: Vec<String>,
}

/// Follow the operator's target.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachTask {
    /// First target: TCP position in the world frame (m); the home pose of the
    /// robot where it is missing.
    #[serde(default)]
    pub position_m: Option<[f64; 3]>,
    /// Its orientation, w x y z; position only where it is missing.
    #[serde(default)]
    pub orientation_wxyz: Option<[f64; 4]>,
}
