//! `cells/NAME.toml`, as in the file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::cells::task_table::TaskHead;
use crate::shape::Shape;

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
    /// Simulated time after which a run of `eval`, or of a cell in one process, has failed (s).
    pub time_limit_s: f64,
    /// The first view of the page, and the camera `front`.
    pub camera: Camera,
    /// `[cameras.NAME]` tables.
    #[serde(default)]
    pub cameras: BTreeMap<String, CameraTable>,
    /// The light of their pictures.
    #[serde(default)]
    pub light: LightTable,
    /// `[[arm]]` tables.
    #[serde(default, rename = "arm")]
    pub arms: Vec<ArmTable>,
    /// `[[object]]` tables.
    #[serde(default, rename = "object")]
    pub objects: Vec<ObjectTable>,
    /// `[[fixture]]` tables.
    #[serde(default, rename = "fixture")]
    pub fixtures: Vec<FixtureTable>,
    /// The belt.
    #[serde(default)]
    pub conveyor: Option<ConveyorTable>,
    /// What drops parts.
    #[serde(default)]
    pub dispenser: Option<DispenserTable>,
    /// `[[sensor]]` tables: light barriers.
    #[serde(default, rename = "sensor")]
    pub sensors: Vec<SensorTable>,
    /// An object below this height is taken out of the cell (m); 1 m below all that is in it at
    /// the start where this is not given.
    #[serde(default)]
    pub clear_below_m: Option<f64>,
    /// A reset of the task opens the grippers, sends the arms to their default pose and leaves
    /// the task paused. Where this is false, the job restarts at once from where the arms are.
    #[serde(default = "yes")]
    pub reset_pauses: bool,
    /// Disturbances of observation and drives.
    #[serde(default)]
    pub disturbance: Disturbance,
    /// The job.
    pub task: TaskHead,
}

/// `[disturbance]`: what a real cell adds, none of it where the table is missing. All of it
/// depends on the seed and the tick alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// The task sees each object at most this far from where it is, along each axis; the same
    /// for all of the run (m).
    pub position_offset_m: f64,
    /// The same, drawn for each decision (m).
    pub position_noise_m: f64,
    /// The task sees each object turned about z by at most this much; the same for all of the
    /// run (rad).
    pub yaw_offset_rad: f64,
    /// The same, drawn for each decision (rad).
    pub yaw_noise_rad: f64,
    /// The drives of an arm follow the joint setpoints this much later, in whole ticks (s).
    pub drive_delay_s: f64,
}

/// `[light]` of the pictures of cameras: a distant light, and light from everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightTable {
    /// The distant light is in the direction (`from_x`, `from_y`, 1), world frame.
    pub from_x: f64,
    /// See `from_x`.
    pub from_y: f64,
    /// Distant light on a surface that faces it, 0 to 1.
    pub direct: f64,
    /// Light on every surface that faces up, 0 to 1.
    pub from_above: f64,
    /// Light on every surface that faces down, 0 to 1.
    pub from_below: f64,
}

impl Default for LightTable {
    fn default() -> Self {
        Self {
            from_x: 0.35,
            from_y: -0.45,
            direct: 0.55,
            from_above: 0.52,
            from_below: 0.30,
        }
    }
}

/// `[camera]`: world frame.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Location of the eye (m).
    pub eye_m: [f64; 3],
    /// Target of the view (m).
    pub target_m: [f64; 3],
}

/// `[cameras.NAME]`: a camera whose pictures are computed, in the world frame or in that of a link.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraTable {
    /// Location of the eye (m).
    pub eye_m: [f64; 3],
    /// Target of the view (m); in its place `rotation_wxyz` can be given.
    #[serde(default)]
    pub target_m: Option<[f64; 3]>,
    /// Direction that is up in the picture, for `target_m`; z where it is not given.
    #[serde(default)]
    pub up: Option<[f64; 3]>,
    /// Rotation of the camera, a quaternion w x y z of length 1: x to the right of the picture, y
    /// down, z ahead.
    #[serde(default)]
    pub rotation_wxyz: Option<[f64; 4]>,
    /// Vertical field of view (degrees), 1 to 170; 38 where it is not given.
    #[serde(default)]
    pub fov_deg: Option<f64>,
    /// Width and height (pixels), 1 to 4096; 224 x 224 where it is not given.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
    /// `ARM/LINK`: the camera is carried by that link or frame of the arm's robot; `ARM/tcp` is
    /// its tool centre point.
    #[serde(default)]
    pub link: Option<String>,
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
    /// Whether the arm follows planned paths where its goal is behind something.
    #[serde(default)]
    pub planner: bool,
    /// Program with the controllers of this arm, where it is not the built-in one:
    /// a file beside the cell file, beside `robocell`, or on PATH.
    #[serde(default)]
    pub controller: Option<String>,
}

/// `[[object]]`: something that can be moved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectTable {
    /// Name in the cell; with `count`, the prefix of the numbered names.
    pub name: String,
    /// Makes that many of it: `NAME_01`, `NAME_02` and so on, with three digits from
    /// 100 up.
    #[serde(default)]
    pub count: Option<u32>,
    /// From one of them to the next (m).
    #[serde(default)]
    pub pitch_m: [f64; 3],
    /// Its shape.
    pub shape: Shape,
    /// Other shapes it may have instead: the seed picks, each as often.
    #[serde(default)]
    pub other_shapes: Vec<Shape>,
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
    /// Orientation, w x y z, in place of `yaw_rad`.
    #[serde(default)]
    pub orientation_wxyz: Option<[f64; 4]>,
    /// How far the seed moves it.
    #[serde(default)]
    pub spawn: SpawnArea,
    /// Not in the simulation until the conveyor or the dispenser brings it.
    #[serde(default)]
    pub parked: bool,
    /// Whether motion policies can keep away from it.
    #[serde(default)]
    pub obstacle: bool,
    /// Whether it may fall asleep while it still trembles a little (0.05 m/s), as in a heap,
    /// which costs physics next to nothing. Without it, an object falls asleep once it has
    /// not moved for half a second.
    #[serde(default)]
    pub sleeps: bool,
    /// Slows its turning, so that a pile comes to rest (1/s).
    #[serde(default)]
    pub angular_damping: f64,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// `[conveyor]`: a fixture whose surface moves.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConveyorTable {
    /// Name of the fixture.
    pub fixture: String,
    /// Velocity of its surface while it runs, world frame (m/s).
    pub velocity_m_s: [f64; 3],
    /// The objects that it brings.
    #[serde(default)]
    pub supply: Option<SupplyTable>,
}

/// `[conveyor.supply]`: where objects come into the cell, on request.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SupplyTable {
    /// `name` of the parked objects it brings.
    pub objects: String,
    /// Where they come, centre, world frame (m).
    pub position_m: [f64; 3],
    /// Turn about z (rad).
    #[serde(default)]
    pub yaw_rad: f64,
    /// How far the seed moves that.
    #[serde(default)]
    pub spawn: SpawnArea,
    /// How fast they come, world frame (m/s).
    #[serde(default)]
    pub velocity_m_s: [f64; 3],
    /// Share of them that comes upside down, from 0 to 1; the seed picks which.
    #[serde(default)]
    pub flipped_share: f64,
    /// No more come while that many are on the belt.
    pub max_waiting: u32,
    /// Time between two of them at least (s).
    pub cool_down_s: f64,
}

/// `[dispenser]`: drops parts.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DispenserTable {
    /// `name` of the parked objects it drops.
    pub objects: String,
    /// Where the first of a drop comes out, centre, world frame (m).
    pub position_m: [f64; 3],
    /// Half widths of its mouth along x and y (m); the seed picks within.
    pub spread_m: [f64; 2],
    /// The next of the same drop comes out this much higher (m).
    pub layer_m: f64,
    /// Parts of one drop.
    pub per_drop: u32,
    /// Time between two drops at least (s).
    pub interval_s: f64,
}

/// `[[sensor]]`: a light barrier along a ray.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorTable {
    /// Name in the cell.
    pub name: String,
    /// Start of the ray, world frame (m).
    pub position_m: [f64; 3],
    /// Where it goes, any length but zero.
    pub direction: [f64; 3],
    /// Length of the ray (m).
    pub range_m: f64,
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

/// `[[fixture]]`: a body that does not move.
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
    /// Orientation, w x y z, in place of `yaw_rad`.
    #[serde(default)]
    pub orientation_wxyz: Option<[f64; 4]>,
    /// Friction coefficient.
    pub friction: f64,
    /// Whether it is there in physics; without, it only keeps motion away.
    #[serde(default = "yes")]
    pub solid: bool,
    /// Whether motion policies keep away from it.
    pub obstacle: bool,
    /// Red, green, blue from 0 to 1.
    pub colour: [f64; 3],
}

/// `cube`, or `bin_07`, or `part_042`.
pub(crate) fn numbered(object: &ObjectTable, index: u32) -> String {
    match object.count {
        None => object.name.clone(),
        Some(count) if count < 100 => format!("{}_{:02}", object.name, index + 1),
        Some(_) => format!("{}_{:03}", object.name, index + 1),
    }
}

fn yes() -> bool {
    true
}

/// The JSON Schema of a cell file, for editors.
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(CellFile).to_value()
}
