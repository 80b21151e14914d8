//! Messages of ROS 2, field by field in the order of their `.msg` files.
//!
//! CDR has no names: a field that is missing or out of order shifts all that follow, and the
//! receiver reads garbage without an error. So unused fields are here as well.

use serde::{Deserialize, Serialize};

/// `builtin_interfaces/msg/Time`, and `Duration`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds.
    pub sec: i32,
    /// Nanoseconds, less than a second.
    pub nanosec: u32,
}

impl Time {
    /// Of nanoseconds of simulated time.
    pub fn of_ns(ns: u64) -> Self {
        let (sec, nanosec) = (ns / 1_000_000_000, ns % 1_000_000_000);
        Self {
            // Until the year 2038 of simulated time; the type is that of ROS.
            sec: i32::try_from(sec).unwrap_or(i32::MAX),
            nanosec: u32::try_from(nanosec).unwrap_or(0),
        }
    }

    /// In nanoseconds.
    pub fn ns(self) -> i64 {
        i64::from(self.sec) * 1_000_000_000 + i64::from(self.nanosec)
    }
}

/// `std_msgs/msg/Header`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Simulated time.
    pub stamp: Time,
    /// Frame of what follows.
    pub frame_id: String,
}

/// `sensor_msgs/msg/JointState`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct JointState {
    /// Time.
    pub header: Header,
    /// Names of the joints.
    pub name: Vec<String>,
    /// rad or m.
    pub position: Vec<f64>,
    /// rad/s or m/s.
    pub velocity: Vec<f64>,
    /// N·m or N.
    pub effort: Vec<f64>,
}

/// `geometry_msgs/msg/Vector3`, and `Point`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// `geometry_msgs/msg/Quaternion`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Of the axis.
    pub x: f64,
    /// Of the axis.
    pub y: f64,
    /// Of the axis.
    pub z: f64,
    /// Cosine of half the angle.
    pub w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self {
            x: 0.0,
            y: 0.0,
            z: 0.0,
            w: 1.0,
        }
    }
}

/// `geometry_msgs/msg/Pose`, and `Transform`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub position: Vector3,
    /// Unit quaternion.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// Time and frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// `geometry_msgs/msg/TransformStamped`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Time and parent frame.
    pub header: Header,
    /// Child frame.
    pub child_frame_id: String,
    /// Pose of the child in its parent.
    pub transform: Pose,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    /// All of them.
    pub transforms: Vec<TransformStamped>,
}

/// `rosgraph_msgs/msg/Clock`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Simulated time.
    pub clock: Time,
}

/// `std_msgs/msg/String`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Text {
    /// The text.
    pub data: String,
}

/// `std_msgs/msg/ColorRGBA`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Color {
    /// Red, 0 to 1.
    pub r: f32,
    /// Green, 0 to 1.
    pub g: f32,
    /// Blue, 0 to 1.
    pub b: f32,
    /// Opacity, 0 to 1.
    pub a: f32,
}

/// `visualization_msgs/msg/Marker`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// Time and frame.
    pub header: Header,
    /// Namespace of `id`.
    pub ns: String,
    /// Number in the namespace.
    pub id: i32,
    /// Which shape: [`Marker::CUBE`] and others.
    pub kind: i32,
    /// [`Marker::ADD`] or [`Marker::DELETE`].
    pub action: i32,
    /// Pose of its centre.
    pub pose: Pose,
    /// Full lengths (m).
    pub scale: Vector3,
    /// Colour.
    pub color: Color,
    /// Time for which it is shown; zero for ever.
    pub lifetime: Time,
    /// Whether its frame is looked up again as it moves.
    pub frame_locked: bool,
    /// Unused, as all following fields.
    pub points: Vec<Vector3>,
    /// Unused.
    pub colors: Vec<Color>,
    /// Unused.
    pub texture_resource: String,
    /// Unused.
    pub texture: CompressedImage,
    /// Unused.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// Unused.
    pub text: String,
    /// Unused.
    pub mesh_resource: String,
    /// Unused.
    pub mesh_file: MeshFile,
    /// Unused.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A cuboid.
    pub const CUBE: i32 = 1;
    /// An ellipsoid.
    pub const SPHERE: i32 = 2;
    /// A cylinder along z.
    pub const CYLINDER: i32 = 3;
    /// Shown, or changed.
    pub const ADD: i32 = 0;
    /// No longer shown.
    pub const DELETE: i32 = 2;
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time and frame.
    pub header: Header,
    /// Of the data.
    pub format: String,
    /// The image.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/UVCoordinate`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    /// Along the width.
    pub u: f32,
    /// Along the height.
    pub v: f32,
}

/// `visualization_msgs/msg/MeshFile`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name.
    pub filename: String,
    /// Its bytes.
    pub data: Vec<u8>,
}

/// `visualization_msgs/msg/MarkerArray`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// All of them.
    pub markers: Vec<Marker>,
}

/// Response of `std_srvs/srv/Trigger`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it is done or under way.
    pub success: bool,
    /// What to tell the person.
    pub message: String,
}
