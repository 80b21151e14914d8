//! Messages of Foxglove's published JSON schemas, for tools that know them.

use ipc_types::topic::Process;
use ipc_types::trace::TraceKind;
use ipc_types::world::OBJECT_ASLEEP;
use ipc_types::{ArmState, Health, Pose, TraceLine, Wire, WorldState};
use serde::Serialize;
use serde_json::{Value, json};

use crate::links::Links;

pub(crate) const FRAME_TRANSFORMS: &str = r#"{"title":"foxglove.FrameTransforms","type":"object","properties":{"transforms":{"type":"array","items":{"type":"object","properties":{"timestamp":{"type":"object","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"parent_frame_id":{"type":"string"},"child_frame_id":{"type":"string"},"translation":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},"rotation":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}}}}}}}"#;
pub(crate) const SCENE_UPDATE: &str = r#"{"title":"foxglove.SceneUpdate","type":"object","properties":{"deletions":{"type":"array","items":{"type":"object"}},"entities":{"type":"array","items":{"type":"object","properties":{"timestamp":{"type":"object"},"frame_id":{"type":"string"},"id":{"type":"string"},"lifetime":{"type":"object"},"frame_locked":{"type":"boolean"},"metadata":{"type":"array","items":{"type":"object"}},"arrows":{"type":"array","items":{"type":"object"}},"cubes":{"type":"array","items":{"type":"object","properties":{"pose":{"type":"object"},"size":{"type":"object"},"color":{"type":"object"}}}},"spheres":{"type":"array","items":{"type":"object"}},"cylinders":{"type":"array","items":{"type":"object"}},"lines":{"type":"array","items":{"type":"object"}},"triangles":{"type":"array","items":{"type":"object"}},"texts":{"type":"array","items":{"type":"object"}},"models":{"type":"array","items":{"type":"object"}}}}}}}"#;
pub(crate) const JOINT_STATES: &str = r#"{"title":"foxglove.JointStates","type":"object","properties":{"timestamp":{"type":"object","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"joints":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"position":{"type":"number"},"velocity":{"type":"number"},"effort":{"type":"number"}}}}}}"#;
pub(crate) const TRACKING: &str = r#"{"type":"object","properties":{"timestamp":{"type":"object","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"joints":{"type":"array","items":{"type":"object","properties":{"name":{"type":"string"},"error":{"type":"number"}}}}}}"#;
pub(crate) const LOG: &str = r#"{"title":"foxglove.Log","type":"object","properties":{"timestamp":{"type":"object","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},"level":{"type":"integer"},"message":{"type":"string"},"name":{"type":"string"},"file":{"type":"string"},"line":{"type":"integer"}}}"#;

/// Frame in which all poses are given.
pub(crate) const WORLD: &str = "world";
/// Resting objects are included at ticks that are multiples of this.
// Once a second: a viewer that opens the file anywhere has every frame within a second.
const REST_TICKS: u64 = 1000;

/// Names that messages need, taken from the page's scene.
#[derive(Clone, Debug, Default)]
pub struct Names {
    arms: Vec<Arm>,
    objects: Vec<String>,
}

#[derive(Clone, Debug)]
struct Arm {
    tcp: String,
    base: String,
    base_pose: Pose,
    joints: Vec<String>,
    links: Links,
}

impl Names {
    /// The names in `scene`.
    pub fn of(scene: &Value) -> Self {
        // A scene of another version gives fewer names, not an
        // error: the recording must not end.
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let name = |value: &Value| value["name"].as_str().unwrap_or_default().to_owned();
        let arm = |arm: &Value| {
            let base_pose = Pose {
                position: numbers(&arm["base"]["position"]),
                orientation_wxyz: numbers(&arm["base"]["orientation_wxyz"]),
            };
            Arm {
                tcp: format!("{}/tcp", name(arm)),
                base: format!("{}/base", name(arm)),
                base_pose,
                joints: list(&arm["joints"]).iter().map(name).collect(),
                links: Links::of(arm, WORLD, &base_pose),
            }
        };
        Self {
            arms: list(&scene["arms"]).iter().map(arm).collect(),
            objects: list(&scene["objects"]).iter().map(name).collect(),
        }
    }
}

#[derive(Serialize)]
struct Time {
    sec: u64,
    nsec: u64,
}

impl Time {
    fn of(ns: u64) -> Self {
        Self {
            sec: ns / 1_000_000_000,
            nsec: ns % 1_000_000_000,
        }
    }
}

#[derive(Serialize)]
struct Vector3 {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Serialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

#[derive(Serialize)]
struct FrameTransform<'a> {
    timestamp: Time,
    parent_frame_id: &'a str,
    child_frame_id: &'a str,
    translation: Vector3,
    rotation: Quaternion,
}

#[derive(Serialize)]
struct FrameTransforms<'a> {
    transforms: Vec<FrameTransform<'a>>,
}

#[derive(Serialize)]
struct JointState<'a> {
    name: &'a str,
    position: f64,
    velocity: f64,
    effort: f64,
}

#[derive(Serialize)]
struct JointError<'a> {
    name: &'a str,
    error: f64,
}

#[derive(Serialize)]
struct TrackingErrors<'a> {
    timestamp: Time,
    joints: Vec<JointError<'a>>,
}

#[derive(Serialize)]
struct JointStates<'a> {
    timestamp: Time,
    joints: Vec<JointState<'a>>,
}

/// Appends TCPs and links of the arms and the moving objects to `out`, as JSON; once a second,
/// and where `all` is true, all objects and links. A link named `tcp` or `base` replaces our
/// frame of that name.
pub fn transforms(names: &Names, world: &WorldState, all: bool, out: &mut Vec<u8>) {
    let time_ns = world.header.sim_time_ns;
    let tf = |child, pose| transform(time_ns, (WORLD, child), pose);
    let is_all = all || world.header.tick.is_multiple_of(REST_TICKS);
    let mut transforms = Vec::new();
    for (arm, state) in names.arms.iter().zip(world.arms()) {
        // Two transforms of one name would make a viewer jump between both.
        if !arm.links.has(&arm.tcp) {
            transforms.push(tf(&arm.tcp, &state.tcp));
        }
        if is_all && !arm.links.has(&arm.base) {
            transforms.push(tf(&arm.base, &arm.base_pose));
        }
        let links = arm.links.poses(state, is_all);
        transforms
            .extend(links.map(|(parent, child, pose)| transform(time_ns, (parent, child), &pose)));
    }
    for (name, object) in names.objects.iter().zip(world.objects()) {
        if is_all || object.flags & OBJECT_ASLEEP == 0 {
            transforms.push(tf(name, &object.pose));
        }
    }
    write(&FrameTransforms { transforms }, out);
}

/// Appends the joints of arm `arm` to `out`, as JSON; none for an unknown arm.
pub fn joint_states(names: &Names, world: &WorldState, arm: usize, out: &mut Vec<u8>) {
    let (named, state) = (names.arms.get(arm), world.arms().get(arm));
    let (named, state) = named.zip(state).map_or_else(
        || (&[][..], ArmState::zeroed()),
        |(named, state)| (&named.joints[..], *state),
    );
    let values = state.joint_positions.iter().zip(&state.joint_velocities);
    let values = values.zip(&state.joint_efforts);
    let joints = named.iter().zip(values);
    let joints = joints.map(|(name, ((position, velocity), effort))| JointState {
        name,
        position: short(*position),
        velocity: short(*velocity),
        effort: short(*effort),
    });
    let states = JointStates {
        timestamp: Time::of(world.header.sim_time_ns),
        joints: joints.take(state.joint_count as usize).collect(),
    };
    write(&states, out);
}

/// Appends the differences between the joints of arm `arm` and the setpoints of their drives to
/// `out`, as JSON; none for an unknown arm.
pub fn tracking_errors(names: &Names, world: &WorldState, arm: usize, out: &mut Vec<u8>) {
    let (named, state) = (names.arms.get(arm), world.arms().get(arm));
    let joints = named.zip(state).into_iter().flat_map(|(named, state)| {
        let count = state.joint_count as usize;
        let values = state.joint_positions.iter().zip(&state.setpoint_positions);
        let joints = named.joints.iter().zip(values).take(count);
        joints.map(|(name, (position, setpoint))| JointError {
            name,
            error: short(position - setpoint),
        })
    });
    let errors = TrackingErrors {
        timestamp: Time::of(world.header.sim_time_ns),
        joints: joints.collect(),
    };
    write(&errors, out);
}

/// Six decimals suffice for plots and pictures; every bit is in the channels of our own
/// structs.
fn short(value: f64) -> f64 {
    (value * 1.0e6).round() / 1.0e6
}

fn write(message: &impl Serialize, out: &mut Vec<u8>) {
    // Neither names nor numbers can fail, and memory accepts all.
    let _written = serde_json::to_writer(out, message).is_ok();
}

/// A line for people; `None` for a line that draws pictures.
pub fn log(line: &TraceLine) -> Option<Value> {
    TraceKind::from_code(line.kind).filter(|kind| kind.is_for_people())?;
    Some(json!({
        "timestamp": time(line.header.sim_time_ns),
        // Level 2 is "info" in Foxglove's schema; the trace has no levels.
        "level": 2,
        "message": line.text.as_str(),
        "name": Process::Task.name(),
        "file": "",
        "line": 0,
    }))
}

/// Health, in a format of this project.
pub fn health(health: &Health) -> Value {
    json!({
        "pid": health.pid,
        "generation": health.header.generation,
        "cycles": health.cycles,
        "missed": health.missed_cycles,
        "rejected": health.rejected,
        "fenced": health.fenced,
        "rate_hz": health.rate_hz,
        "late_p50_us": health.lateness_p50_ns * 1.0e-3,
        "late_p99_us": health.lateness_p99_ns * 1.0e-3,
        "late_max_us": health.lateness_max_ns * 1.0e-3,
        "body_p50_us": health.body_p50_ns * 1.0e-3,
        "body_p99_us": health.body_p99_ns * 1.0e-3,
        "note": health.note.as_str(),
    })
}

pub(crate) fn numbers<const N: usize>(list: &Value) -> [f64; N] {
    let mut out = [0.0; N];
    for (to, from) in out.iter_mut().zip(list.as_array().into_iter().flatten()) {
        *to = from.as_f64().unwrap_or(0.0);
    }
    out
}

/// `pose` of frame `child` in frame `parent`.
fn transform<'a>(
    time_ns: u64,
    (parent, child): (&'a str, &'a str),
    pose: &Pose,
) -> FrameTransform<'a> {
    let ([x, y, z], [w, i, j, k]) = (pose.position.map(short), pose.orientation_wxyz.map(short));
    FrameTransform {
        timestamp: Time::of(time_ns),
        parent_frame_id: parent,
        child_frame_id: child,
        translation: Vector3 { x, y, z },
        rotation: Quaternion {
            x: i,
            y: j,
            z: k,
            w,
        },
    }
}

pub(crate) fn time(ns: u64) -> Value {
    json!(Time::of(ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_and_poses_are_told_with_six_decimals() {
        let base = json!({ "position": [1, 0, 0], "orientation_wxyz": [1, 0, 0, 0] });
        let joints = json!([{ "name": "j1" }, { "name": "finger" }]);
        let scene = json!({
            "arms": [{ "name": "arm", "base": base, "joints": joints }],
            "objects": [{ "name": "cube" }, { "name": "rests" }],
        });
        let mut world = WorldState::zeroed();
        world.header.sim_time_ns = 2_500_000_000;
        world.header.tick = 2500;
        (world.arm_count, world.object_count) = (1, 2);
        (world.arms[0].joint_count, world.arms[0].joint_positions[0]) = (1, 0.123_456_789);
        world.objects[0].pose.position[2] = -1.0 / 3.0;
        world.objects[1].flags = OBJECT_ASLEEP;
        let names = Names::of(&scene);
        let mut out = Vec::new();
        joint_states(&names, &world, 0, &mut out);
        let said: Value = serde_json::from_slice(&out).unwrap();
        let joint = json!({ "name": "j1", "position": 0.123_457, "velocity": 0.0, "effort": 0.0 });
        let time = json!({ "sec": 2, "nsec": 500_000_000 });
        assert_eq!(said, json!({ "timestamp": time, "joints": [joint] }));
        out.clear();
        transforms(&names, &world, false, &mut out);
        let said: Value = serde_json::from_slice(&out).unwrap();
        let list = said["transforms"].as_array().unwrap();
        let children: Vec<_> = list.iter().map(|t| &t["child_frame_id"]).collect();
        assert_eq!(children, ["arm/tcp", "cube"]);
        assert_eq!(list[1]["translation"]["z"], json!(-0.333_333));
        out.clear();
        transforms(&names, &world, true, &mut out);
        let said: Value = serde_json::from_slice(&out).unwrap();
        let list = said["transforms"].as_array().unwrap();
        let children: Vec<_> = list.iter().map(|t| &t["child_frame_id"]).collect();
        assert_eq!(children, ["arm/tcp", "arm/base", "cube", "rests"]);
        out.clear();
        world.arms[0].setpoint_positions[0] = 0.123_4;
        tracking_errors(&names, &world, 0, &mut out);
        let said: Value = serde_json::from_slice(&out).unwrap();
        assert_eq!(said["joints"], json!([{ "name": "j1", "error": 5.7e-5 }]));
    }
}
