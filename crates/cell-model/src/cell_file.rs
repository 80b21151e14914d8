//! `cells/NAME.toml` as it stands in the file.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::shape::Shape;
use crate::task_spec::TaskSpec;

/// The whole file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CellFile {
    /// One line for `robocell list`.
    pub description: String,
    /// Policies that can run this cell.
    pub policies: Vec<String>,
    /// The one that runs where none is named.
    pub default_policy: String,
    /// Simulated time after which the run has failed (s).
    pub time_limit_s: f64,
    /// Where a picture is taken from.
    pub camera: Camera,
    /// `[[arm]]` tables.
    #[serde(default, rename = "arm")]
    pub arms: Vec<ArmTable>,
    /// `[[object]]` tables.
    #[serde(default, rename = "object")]
    pub objects: Vec<ObjectTable>,
    /// `[[fixture]]` tables.
    #[serde(default, rename = "fixture")]
    pub fixtures: Vec<FixtureTable>,
    /// What the policies work with.
    pub task: TaskSpec,
}

/// `[camera]`: world frame.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Place of the eye (m).
    pub eye_m: [f64; 3],
    /// What it looks at (m).
    pub target_m: [f64; 3],
}

/// `[[arm]]`: a robot in the cell.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ArmTable {
    /// Name in the cell.
    pub name: String,
    /// Folder in `robots/`.
    pub robot: String,
    /// Base in the world frame (m).
    pub base_position_m: [f64; 3],
    /// Turn of the base about z (rad).
    #[serde(default)]
    pub base_yaw_rad: f64,
    /// Joint positions at the start (rad or m); the robot's own where missing.
    #[serde(default)]
    pub home_joint_positions: Option<Vec<f64>>,
}

/// `[[object]]`: something that can be moved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectTable {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Mass (kg).
    pub mass_kg: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// The seed varies friction by this much to both sides.
    #[serde(default)]
    pub friction_spread: f64,
    /// Centre at the start, world frame (m).
    pub position_m: [f64; 3],
    /// Turn about z at the start (rad).
    #[serde(default)]
    pub yaw_rad: f64,
    /// How far the seed moves it.
    #[serde(default)]
    pub spawn: SpawnArea,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// Half widths of the area the seed picks from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpawnArea {
    /// Along x to both sides (m).
    pub x_m: f64,
    /// Along y to both sides (m).
    pub y_m: f64,
    /// About z to both sides (rad).
    pub yaw_rad: f64,
}

/// `[[fixture]]`: something that stands still.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixtureTable {
    /// Name in the cell.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Centre in the world frame (m).
    pub position_m: [f64; 3],
    /// Turn about z (rad).
    #[serde(default)]
    pub yaw_rad: f64,
    /// Friction coefficient.
    pub friction: f64,
    /// Whether motion policies keep away from it.
    pub obstacle: bool,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// The JSON Schema of a cell file, for editors.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(CellFile).to_value()
}
