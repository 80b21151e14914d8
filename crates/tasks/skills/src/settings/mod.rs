//! `[task]` of the kinds `tree`, `machine` and `matrix`.

pub(crate) mod place;

use std::collections::BTreeMap;

use cell_model::{Cell, Checker, ModelError, suggest};
use nalgebra::Vector3;
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::ability::{self, Need};
use crate::setup::{ArmSetup, ObjectSetup, Tool};

pub use place::{Pattern, PlaceTable};

/// What one arm does, where the arms do different things.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotTable {
    /// File with its behaviour, beside the cell file.
    pub behaviour: String,
    /// Name of the blackboard it shares with other arms of the same name.
    #[serde(default = "shared")]
    pub board: String,
}

fn shared() -> String {
    "shared".to_owned()
}

/// A job in a behaviour file, without Rust.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileTask {
    /// File with the behaviour, beside the cell file.
    #[serde(default)]
    pub behaviour: String,
    /// Trees only: what each arm does, where they do different things.
    #[serde(default)]
    pub robot: BTreeMap<String, RobotTable>,
    /// Trees only: an arm whose tree succeeded has done its part and is not ticked
    /// again.
    #[serde(default)]
    pub once: bool,
    /// Places where objects belong, by name.
    #[serde(default)]
    pub place: BTreeMap<String, PlaceTable>,
}

impl FileTask {
    /// The behaviour of an arm, and its shared blackboard.
    pub(crate) fn of_arm(&self, arm: &str) -> (&str, &str) {
        self.robot
            .get(arm)
            .map_or((self.behaviour.as_str(), "shared"), |table| {
                (table.behaviour.as_str(), table.board.as_str())
            })
    }
}

impl Settings for FileTask {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        let arms: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
        for name in self.robot.keys() {
            if !arms.contains(&name.as_str()) {
                let advice = suggest::advice(name, &arms);
                let key = format!("task.robot.{name}");
                return Err(at.refuse(&key, format!("'{name}'"), format!("no such arm; {advice}")));
            }
        }
        // Each arm needs a file: an arm without one would have no tree.
        let missing = arms.iter().find(|arm| self.of_arm(arm).0.is_empty());
        if missing.is_some() {
            let allowed = "the name of a file beside the cell file is needed";
            return Err(at.refuse("task.behaviour", "''", allowed));
        }
        check_places(&self.place, cell, at)
    }
}

/// A job in Rust that needs nothing but places.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Places {
    /// Places where objects belong, by name.
    #[serde(default)]
    pub place: BTreeMap<String, PlaceTable>,
}

impl Settings for Places {
    fn check(&self, cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        check_places(&self.place, cell, at)
    }
}

/// Refuses places with invalid values, and those that no arm of `cell` reaches.
///
/// # Errors
/// [`ModelError::Value`].
pub fn check_places(
    places: &BTreeMap<String, PlaceTable>,
    cell: &Cell,
    at: &Checker<'_>,
) -> Result<(), ModelError> {
    let arms: Vec<ArmSetup> = cell.arms.iter().map(ArmSetup::of).collect();
    for (name, table) in places {
        let key = format!("task.place.{name}");
        table.check(at, &key)?;
        for (index, slot) in table.slots().iter().enumerate() {
            reached(cell, &arms, slot.position.into()).map_err(|why| {
                let [x, y, z] = slot.position;
                let value = format!("[{x:.3}, {y:.3}, {z:.3}] in slot {index}");
                at.refuse(&format!("{key}.position_m"), value, why)
            })?;
        }
    }
    Ok(())
}

/// Whether some arm reaches a point at which an object of `cell` is set down. The error names
/// the reason for each arm: a job could only fail there (ADR 0026).
fn reached(cell: &Cell, arms: &[ArmSetup], point: Vector3<f64>) -> Result<(), String> {
    let mut why = Vec::new();
    for (arm, spec) in arms.iter().zip(&cell.arms) {
        let name = &arm.name;
        // Without kinematics first: it is a comparison, while the search takes 3 to 63 ms (ADR
        // 0026).
        if !arm.reaches(point) {
            let (away, reach) = ((point - arm.base).xy().norm(), arm.reach_m);
            why.push(format!(
                "'{name}' reaches {reach:.2} m, and it is {away:.2} m from its base"
            ));
            continue;
        }
        match ability::lacks(arm, Need::Reach(spec, &tool_points(cell, arm.tool, point))) {
            None => return Ok(()),
            Some(lack) => why.push(format!("'{name}' {lack}, pointing down")),
        }
    }
    // A cell without an arm: no arm refused the point.
    if why.is_empty() {
        return Ok(());
    }
    let why = why.join("; ");
    Err(format!(
        "no arm reaches it: {why}; move the place or the base of an arm"
    ))
}

/// Positions of a tool that sets down the lowest and the highest object at `point` (m).
fn tool_points(cell: &Cell, tool: Tool, point: Vector3<f64>) -> Vec<Vector3<f64>> {
    let objects = cell.objects.iter().map(ObjectSetup::of);
    let height = |object: ObjectSetup| object.half_height_m + tool.grasp_height(&object);
    let heights = objects.map(height);
    let (low, high) = heights.fold((f64::INFINITY, 0.0_f64), |(low, high), height| {
        (low.min(height), high.max(height))
    });
    let mut all = vec![low.min(high), high];
    all.dedup();
    let above = |height: f64| point + Vector3::new(0.0, 0.0, height);
    all.into_iter().map(above).collect()
}
