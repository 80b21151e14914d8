//! `[task]` of the kinds `tree`, `machine` and `matrix`.

use std::collections::BTreeMap;

use cell_model::check::MAX_COORDINATE_M;
use cell_model::{Cell, Checker, ModelError, suggest};
use nalgebra::Vector3;
use robocell_task::Settings;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::ability::{self, Need};
use crate::setup::{self, ArmSetup, ObjectSetup, Tool};

/// Largest number of slots of a place: the occupied ones are a mask of 64 bits.
const MAX_SLOTS: u32 = 64;

/// A place where objects belong: one slot, or a pattern of slots.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceTable {
    /// Point of the surface below the centre of the first object, world frame
    /// (m).
    pub position_m: [f64; 3],
    /// Turn of the objects and of the pattern about the vertical axis (rad).
    #[serde(default)]
    pub yaw_rad: f64,
    /// More slots than one.
    #[serde(default)]
    pub pattern: Option<Pattern>,
}

/// An arrangement of slots. Slots are filled in the order given here.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Pattern {
    /// One on top of the other.
    Stack {
        /// Objects.
        layers: u32,
        /// Height of one layer (m).
        layer_height_m: f64,
    },
    /// Side by side, row by row, layer by layer, beginning at `position_m`.
    Grid {
        /// Objects along x, along y and upwards.
        count: [u32; 3],
        /// Distance of neighbours along x, along y and upwards (m).
        pitch_m: [f64; 3],
        /// Order of the slots, by their numbers from 0 up in the default order;
        /// the default order where it is missing.
        #[serde(default)]
        order: Option<Vec<u32>>,
    },
    /// A row of objects along y, centred on `position_m`, on it a row with one
    /// less, and so on.
    Pyramid {
        /// Objects of the lowest row.
        base: u32,
        /// Distance of neighbours (m).
        pitch_m: f64,
        /// Height of one layer (m).
        layer_height_m: f64,
    },
}

impl PlaceTable {
    /// By slot: its offset from the first position in the frame of the place (m).
    pub(crate) fn offsets(&self) -> Vec<[f64; 3]> {
        match &self.pattern {
            None => vec![[0.0; 3]],
            Some(Pattern::Stack {
                layers,
                layer_height_m,
            }) => (0..*layers)
                .map(|layer| [0.0, 0.0, f64::from(layer) * layer_height_m])
                .collect(),
            Some(Pattern::Grid {
                count,
                pitch_m,
                order,
            }) => grid(*count, *pitch_m, order.as_deref()),
            Some(Pattern::Pyramid {
                base,
                pitch_m,
                layer_height_m,
            }) => pyramid(*base, *pitch_m, *layer_height_m),
        }
    }

    fn check(&self, at: &Checker<'_>, key: &str) -> Result<(), ModelError> {
        at.position(&format!("{key}.position_m"), &self.position_m)?;
        at.number(&format!("{key}.yaw_rad"), self.yaw_rad, -7.0, 7.0)?;
        let key = format!("{key}.pattern");
        let (count, lengths) = match &self.pattern {
            None => return Ok(()),
            Some(Pattern::Stack {
                layers,
                layer_height_m,
            }) => (*layers, vec![*layer_height_m]),
            Some(Pattern::Grid {
                count: [x, y, z],
                pitch_m,
                order,
            }) => {
                let count = x.saturating_mul(*y).saturating_mul(*z);
                check_order(at, &key, order.as_deref(), count)?;
                (count, pitch_m.to_vec())
            }
            Some(Pattern::Pyramid {
                base,
                pitch_m,
                layer_height_m,
            }) => (
                base.saturating_mul(base.saturating_add(1)) / 2,
                vec![*pitch_m, *layer_height_m],
            ),
        };
        if count == 0 || count > MAX_SLOTS {
            let allowed = format!("1 to {MAX_SLOTS} are allowed");
            return Err(at.refuse(&key, format!("of {count} slots"), allowed));
        }
        at.numbers(&key, &lengths, -MAX_COORDINATE_M, MAX_COORDINATE_M)
    }
}

fn check_order(
    at: &Checker<'_>,
    key: &str,
    order: Option<&[u32]>,
    count: u32,
) -> Result<(), ModelError> {
    let Some(order) = order else { return Ok(()) };
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    // A number that is missing would be a slot that is never filled.
    if sorted.iter().copied().eq(0..count.min(MAX_SLOTS)) {
        return Ok(());
    }
    let allowed = format!("each number from 0 to {} is needed once", count.max(1) - 1);
    Err(at.refuse(&format!("{key}.order"), format!("{order:?}"), allowed))
}

fn grid(count: [u32; 3], pitch: [f64; 3], order: Option<&[u32]>) -> Vec<[f64; 3]> {
    let [nx, ny, nz] = count;
    let mut all = Vec::new();
    for z in 0..nz.min(MAX_SLOTS) {
        for y in 0..ny.min(MAX_SLOTS) {
            for x in 0..nx.min(MAX_SLOTS) {
                let index = [x, y, z].map(f64::from);
                all.push([0, 1, 2].map(|axis: usize| index[axis] * pitch[axis]));
            }
        }
    }
    match order {
        None => all,
        Some(order) => {
            let slot = |number: &u32| all.get(*number as usize).copied();
            order.iter().filter_map(slot).collect()
        }
    }
}

fn pyramid(base: u32, pitch: f64, layer: f64) -> Vec<[f64; 3]> {
    let base = base.min(MAX_SLOTS);
    let mut all = Vec::new();
    for row in 0..base {
        let width = base - row;
        for index in 0..width {
            let along = f64::from(index) - 0.5 * f64::from(width - 1);
            all.push([0.0, along * pitch, f64::from(row) * layer]);
        }
    }
    all
}

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
        let slots = setup::place(name, table).slots;
        for (index, slot) in slots.iter().enumerate() {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn table(pattern: Pattern) -> PlaceTable {
        PlaceTable {
            position_m: [0.0; 3],
            yaw_rad: 0.0,
            pattern: Some(pattern),
        }
    }

    #[test]
    fn a_pattern_is_filled_from_below() {
        let stack = table(Pattern::Stack {
            layers: 3,
            layer_height_m: 0.05,
        });
        assert_eq!(stack.offsets()[2], [0.0, 0.0, 0.1]);
        let pyramid = table(Pattern::Pyramid {
            base: 3,
            pitch_m: 0.06,
            layer_height_m: 0.05,
        });
        let offsets = pyramid.offsets();
        assert_eq!(offsets.len(), 6);
        assert_eq!(
            (offsets[0], offsets[5]),
            ([0.0, -0.06, 0.0], [0.0, 0.0, 0.1])
        );
        assert!(offsets.windows(2).all(|pair| pair[0][2] <= pair[1][2]));
    }

    #[test]
    fn a_grid_is_filled_in_the_order_of_the_file() {
        let grid = |order| {
            table(Pattern::Grid {
                count: [2, 2, 1],
                pitch_m: [0.1, 0.2, 0.0],
                order,
            })
        };
        assert_eq!(grid(None).offsets()[1], [0.1, 0.0, 0.0]);
        let turned = grid(Some(vec![3, 2, 1, 0]));
        assert_eq!(turned.offsets()[0], [0.1, 0.2, 0.0]);
        let at = Checker::new("a.toml", "");
        assert!(turned.check(&at, "task.place.a").is_ok());
        let twice = grid(Some(vec![0, 1, 1, 2])).check(&at, "task.place.a");
        assert!(twice.unwrap_err().to_string().contains("0 to 3"));
    }

    #[test]
    fn an_endless_pattern_is_refused() {
        let at = Checker::new("a.toml", "");
        let huge = table(Pattern::Grid {
            count: [u32::MAX; 3],
            pitch_m: [0.1; 3],
            order: None,
        });
        assert!(huge.check(&at, "task.place.a").is_err());
        assert!(huge.offsets().len() <= (MAX_SLOTS as usize).pow(3));
    }
}
