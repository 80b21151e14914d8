//! `[task]` with `kind = "pyramid"`.

use std::collections::BTreeMap;

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError, suggest};
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check::{MAX_STACK, fingers_grip, object_names, order, tool_gets_to, within_reach};

/// Take a pyramid of cubes apart; every arm builds a stack of its own.
///
/// Heights of the tool are those of the TCP, whose frame is between the pads.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PyramidTask {
    /// Height of the centre of the lowest cube of a stack, world frame (m).
    #[schemars(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M))]
    pub base_height_m: f64,
    /// Height of one layer (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub layer_height_m: f64,
    /// Cubes in a finished stack of one arm.
    #[schemars(range(min = 1.0, max = MAX_STACK as f64))]
    pub required_count: u32,
    /// TCP above the centre of the cube before it is grasped (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub approach_m: f64,
    /// TCP above the centre of the cube when it is grasped (m).
    #[schemars(range(min = -0.5, max = 0.5))]
    pub grasp_m: f64,
    /// TCP height after the lift, world frame (m).
    #[schemars(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M))]
    pub lift_z_m: f64,
    /// TCP above the cube's goal before it is lowered (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub place_approach_m: f64,
    /// TCP above the cube's goal when it is released, before the place is corrected by the
    /// cube's pose in the hand (m).
    #[schemars(range(min = -0.5, max = 0.5))]
    pub place_m: f64,
    /// TCP above the cube's goal after it was let go (m).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub retract_m: f64,
    /// An object nearer than this to its goal, in the plane, is in place (m).
    #[schemars(range(min = 1.0e-4, max = 1.0))]
    pub goal_tolerance_m: f64,
    /// Finger distance of an open gripper (m).
    #[schemars(range(min = 1.0e-3, max = 1.0))]
    pub open_width_m: f64,
    /// The gripper is open when within this of the open width (m).
    #[schemars(range(min = 1.0e-5, max = 0.5))]
    pub gripper_tolerance_m: f64,
    /// Force per finger (N).
    #[schemars(range(min = 0.1, max = 1.0e4))]
    pub grip_force_n: f64,
    /// A cube further than this from the arm's base, in the plane, is out of
    /// reach (m).
    #[schemars(range(min = 1.0e-2, max = MAX_COORDINATE_M))]
    pub reach_m: f64,
    /// A cube that no arm reaches is taken up to this distance, where motions are slower (m);
    /// `reach_m` without.
    #[schemars(inner(range(min = 1.0e-2, max = MAX_COORDINATE_M)))]
    pub stretched_reach_m: Option<f64>,
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
    #[schemars(inner(range(min = -MAX_COORDINATE_M, max = MAX_COORDINATE_M)))]
    pub goal_m: [f64; 2],
    /// Turn of the hand about the world's z where it points straight down and
    /// its fingers close along y at zero (rad).
    #[schemars(range(min = -7.0, max = 7.0))]
    pub yaw_rad: f64,
    /// Cubes in the order in which this arm tries them.
    pub order: Vec<String>,
}

impl Settings for PyramidTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        let arms: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
        for (name, arm) in &self.robot {
            if !arms.contains(&name.as_str()) {
                let advice = suggest::advice(name, &arms);
                let key = format!("task.robot.{name}");
                return Err(at.refuse(&key, "here", format!("no such arm; {advice}")));
            }
            let key = format!("task.robot.{name}");
            pyramid_arm(at, &key, arm, cell)?;
            let index = arms.iter().position(|known| known == name);
            let spec = index.and_then(|index| cell.arms.get(index));
            let goal = format!("{key}.goal_m");
            within_reach(at, &goal, spec, arm.goal_m, self.reach_m)?;
            fingers_grip(at, cell, index.unwrap_or(0), &arm.order)?;
            let [x, y] = arm.goal_m;
            // The lowest and the highest layer: those between are reached if both are.
            let layers = [0, self.required_count.saturating_sub(1)];
            let height = |layer: u32| self.base_height_m + self.layer_height_m * f64::from(layer);
            tool_gets_to(at, &goal, spec, layers.map(|layer| [x, y, height(layer)]))?;
        }
        if let Some(missing) = arms.iter().find(|name| !self.robot.contains_key(**name)) {
            let allowed = format!("write what [task.robot.{missing}] shall do");
            return Err(at.refuse("task", format!("silent about arm '{missing}'"), allowed));
        }
        if let Some(stretched) = self.stretched_reach_m.filter(|far| *far < self.reach_m) {
            let allowed = format!("it is not less than reach_m, {}", self.reach_m);
            return Err(at.refuse("task.stretched_reach_m", stretched, allowed));
        }
        let wanted = u64::from(self.required_count) * arms.len() as u64;
        // Objects are shared by all arms, so the sum counts.
        if wanted > cell.objects.len() as u64 {
            let allowed = format!(
                "{} arms need {wanted} objects, the cell has {}",
                arms.len(),
                cell.objects.len()
            );
            return Err(at.refuse("task.required_count", self.required_count, allowed));
        }
        Ok(())
    }

    fn grip_force_n(&self, _cell: &Cell) -> f64 {
        self.grip_force_n
    }
}

fn pyramid_arm(
    at: &Checker<'_>,
    key: &str,
    arm: &PyramidArm,
    cell: &Cell,
) -> Result<(), ModelError> {
    order(at, &format!("{key}.order"), &arm.order, &object_names(cell))?;
    // The name becomes a path below `cells/`: no separators, so no file outside of it is read.
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let file = &arm.behaviour;
    let json = std::path::Path::new(file)
        .extension()
        .is_some_and(|e| e == "json");
    if !json || file.len() > 64 || !file.chars().all(plain) {
        return Err(at.refuse(
            &format!("{key}.behaviour"),
            format!("'{file}'"),
            "the name of a .json file in cells/ is needed",
        ));
    }
    let word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    // The name becomes part of keys on the shared blackboard.
    if arm.board.is_empty() || arm.board.len() > 32 || !arm.board.chars().all(word) {
        return Err(at.refuse(
            &format!("{key}.board"),
            format!("'{}'", arm.board),
            "1 to 32 of a-z, 0-9 and _ are allowed",
        ));
    }
    Ok(())
}
