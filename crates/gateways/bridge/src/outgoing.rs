//! Outgoing messages: a state of the cell in, messages out. Pure.
//!
//! Poses of `/tf` are all in `world`, not in the parent link: a message is complete by itself,
//! and no reader has to wait for all of a tree (ADR 0024).

use cell_model::{Cell, Shape};
use ipc_types::decision::Outcome;
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmState, Decision, ObjectState, Pose as CellPose, TraceLine, WorldState};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use serde_json::json;

use crate::endpoints::{Stream, arm_prefix};
use crate::ros::messages::{
    Clock, Color, Header, JointState, Marker, MarkerArray, Pose, Quaternion, Text, TfMessage, Time,
    TransformStamped, Vector3,
};
use crate::ros::{self};

/// The frame of all poses.
pub const WORLD: &str = "world";

/// Makes messages from states of one cell.
pub struct Outgoing<'a> {
    cell: &'a Cell,
    /// By arm: prefix of its names.
    prefixes: Vec<String>,
}

impl<'a> Outgoing<'a> {
    /// For states of `cell`.
    pub fn new(cell: &'a Cell) -> Self {
        let prefix = |arm: &cell_model::ArmSpec| arm_prefix(cell, &arm.name);
        Self {
            cell,
            prefixes: cell.arms.iter().map(prefix).collect(),
        }
    }

    /// The message of `stream` about `world`, in CDR.
    ///
    /// # Errors
    /// If it cannot be encoded.
    pub fn message(
        &self,
        stream: Stream,
        world: &WorldState,
        decision: Option<&Decision>,
    ) -> Result<Vec<u8>, cdr_encoding::Error> {
        match stream {
            Stream::JointStates => ros::encode(&self.joint_states(world)),
            Stream::Transforms => ros::encode(&self.transforms(world)),
            Stream::Clock => ros::encode(&Clock {
                clock: stamp(world),
            }),
            Stream::Markers => ros::encode(&self.markers(world)),
            Stream::State => ros::encode(&self.state(world, decision)),
            // Lines of the trace are not part of a state.
            Stream::Events => ros::encode(&Text::default()),
        }
    }

    fn arms<'s>(
        &'s self,
        world: &'s WorldState,
    ) -> impl Iterator<Item = (&'s cell_model::ArmSpec, &'s str, &'s ArmState)> {
        let named = self.cell.arms.iter().zip(&self.prefixes);
        let arms = named.zip(world.arms());
        arms.map(|((spec, prefix), state)| (spec, prefix.as_str(), state))
    }

    /// All controlled joints, and the fingers.
    pub fn joint_states(&self, world: &WorldState) -> JointState {
        let mut message = JointState {
            header: header(world, ""),
            ..JointState::default()
        };
        for (spec, prefix, state) in self.arms(world) {
            let names = spec.robot.arm_joint_names();
            let joints = names.iter().zip(&state.joint_positions);
            let rates = state.joint_velocities.iter().zip(&state.joint_efforts);
            for ((name, position), (velocity, effort)) in joints.zip(rates) {
                message.name.push(format!("{prefix}{name}"));
                message.position.push(*position);
                message.velocity.push(*velocity);
                message.effort.push(*effort);
            }
            // Fingers are not joints of a state: their positions follow from the width.
            let fingers = spec
                .robot
                .gripper
                .iter()
                .flat_map(|hand| hand.finger_joints);
            for joint in fingers {
                let name = spec.robot.chain.joints().get(joint).map_or("", |j| &j.name);
                message.name.push(format!("{prefix}{name}"));
                // A finger is half the width from the middle.
                message.position.push(0.5 * state.gripper.width);
                message.velocity.push(0.5 * state.gripper.width_velocity);
                message.effort.push(state.gripper.grip_force);
            }
        }
        message
    }

    /// Every frame of every robot, and every object, in the world frame.
    pub fn transforms(&self, world: &WorldState) -> TfMessage {
        let mut transforms = Vec::new();
        let mut add = |child: String, pose: Pose| {
            transforms.push(TransformStamped {
                header: header(world, WORLD),
                child_frame_id: child,
                transform: pose,
            });
        };
        for (spec, prefix, state) in self.arms(world) {
            let robot = &spec.robot;
            let mut positions = robot.with_arm_positions(&state.joint_positions);
            for joint in robot.gripper.iter().flat_map(|hand| hand.finger_joints) {
                if let Some(slot) = positions.get_mut(joint) {
                    *slot = 0.5 * state.gripper.width;
                }
            }
            let links = robot.link_poses(&positions);
            for frame in robot.chain.frames() {
                // Links are numbered from the base, which no joint moves.
                let link = links.get(frame.joint.map_or(0, |joint| joint + 1));
                if let Some(link) = link {
                    let pose = spec.base * link * frame.pose;
                    add(format!("{prefix}{}", frame.name), of_isometry(&pose));
                }
            }
        }
        for (spec, state) in self.cell.objects.iter().zip(world.objects()) {
            if is_there(state) {
                add(format!("object/{}", spec.name), of_pose(&state.pose));
            }
        }
        TfMessage { transforms }
    }

    /// Objects and fixtures.
    pub fn markers(&self, world: &WorldState) -> MarkerArray {
        let mut markers = Vec::new();
        for (id, (spec, state)) in (0..).zip(self.cell.objects.iter().zip(world.objects())) {
            let pose = isometry(&state.pose);
            let mut parts = shapes("object", id, &spec.shape, &pose, spec.colour);
            // Deleted, not left out: a viewer keeps a marker until a message deletes it.
            for marker in &mut parts {
                if !is_there(state) {
                    marker.action = Marker::DELETE;
                }
            }
            markers.extend(parts);
        }
        for (id, fixture) in (0..).zip(&self.cell.fixtures) {
            markers.extend(shapes(
                "fixture",
                id,
                &fixture.shape,
                &fixture.pose,
                fixture.colour,
            ));
        }
        // One time for all, so that a viewer shows them as one scene.
        for marker in &mut markers {
            marker.header = header(world, WORLD);
        }
        MarkerArray { markers }
    }

    /// State for people, for programs without ROS.
    pub fn state(&self, world: &WorldState, decision: Option<&Decision>) -> Text {
        let arms = self.arms(world).map(|(spec, _, state)| {
            let count = spec.robot.arm_joints.len().min(state.joint_positions.len());
            let held = (state.gripper.held_object as usize).checked_sub(1);
            let held = held.and_then(|index| self.cell.objects.get(index));
            json!({
                "name": spec.name,
                "joint_names": spec.robot.arm_joint_names(),
                "joint_positions": state.joint_positions.get(..count),
                "tcp": state.tcp.position,
                "tcp_wxyz": state.tcp.orientation_wxyz,
                "gripper_width_m": state.gripper.width,
                "holds": held.map(|object| &object.name),
                "limit_violations": state.limit_violations,
            })
        });
        let objects = self.cell.objects.iter().zip(world.objects());
        let objects = objects.filter(|(_, state)| is_there(state));
        let objects = objects.map(|(spec, state)| {
            json!({ "name": spec.name, "position": state.pose.position,
                    "wxyz": state.pose.orientation_wxyz })
        });
        let outcome = decision.and_then(|decision| Outcome::from_code(decision.outcome));
        let state = json!({
            "sim_time_s": world.header.sim_time_ns as f64 * 1.0e-9,
            "tick": world.header.tick,
            "paused": world.has(ipc_types::world::FLAG_PAUSED),
            "task": {
                "outcome": outcome.map(|outcome| format!("{outcome:?}").to_lowercase()),
                "phase": decision.map(|decision| decision.phase.as_str()),
                "paused": world.panel.task_paused != 0,
            },
            "arms": arms.collect::<Vec<_>>(),
            "objects": objects.collect::<Vec<_>>(),
        });
        Text {
            data: state.to_string(),
        }
    }
}

/// A line of the task as an event; `None` for a line that draws pictures.
pub fn event(line: &TraceLine) -> Option<Text> {
    let kind = TraceKind::from_code(line.kind).filter(|kind| kind.is_for_people())?;
    let event = TraceEvent::from_code(line.event).and_then(TraceEvent::name);
    let kind = match kind {
        TraceKind::Transition => "transition",
        TraceKind::Lifecycle => "lifecycle",
        _ => "log",
    };
    let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
    let text = line.text.as_str();
    let event = json!({ "sim_time_s": time_s, "kind": kind, "event": event, "text": text });
    Some(Text {
        data: event.to_string(),
    })
}

fn is_there(object: &ObjectState) -> bool {
    object.flags & OBJECT_ENABLED != 0
}

fn stamp(world: &WorldState) -> Time {
    Time::of_ns(world.header.sim_time_ns)
}

fn header(world: &WorldState, frame: &str) -> Header {
    Header {
        stamp: stamp(world),
        frame_id: frame.to_owned(),
    }
}

/// Markers of a shape: one, or one for each panel of a bin and each end of a capsule.
fn shapes(
    kind: &str,
    id: i32,
    shape: &Shape,
    pose: &Isometry3<f64>,
    [red, green, blue]: [f64; 3],
) -> Vec<Marker> {
    let parts: Vec<(i32, [f64; 3], Isometry3<f64>)> = match (shape.panels(), shape) {
        (Some(panels), _) => {
            let part = |panel: &cell_model::Panel| {
                let at = pose * Translation3::from(panel.centre);
                (Marker::CUBE, panel.size.into(), at)
            };
            panels.iter().map(part).collect()
        }
        (None, Shape::Box { size_m } | Shape::Bin { size_m, .. }) => {
            vec![(Marker::CUBE, *size_m, *pose)]
        }
        (None, Shape::Sphere { radius_m }) => vec![(Marker::SPHERE, [2.0 * radius_m; 3], *pose)],
        (None, Shape::Cylinder { radius_m, height_m }) => {
            let width = 2.0 * radius_m;
            vec![(Marker::CYLINDER, [width, width, *height_m], *pose)]
        }
        (None, Shape::Capsule { radius_m, height_m }) => {
            let width = 2.0 * radius_m;
            let end = |z: f64| {
                (
                    Marker::SPHERE,
                    [width; 3],
                    pose * Translation3::new(0.0, 0.0, z),
                )
            };
            let middle = (Marker::CYLINDER, [width, width, *height_m], *pose);
            vec![middle, end(0.5 * height_m), end(-0.5 * height_m)]
        }
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "colours are single precision"
    )]
    let color = Color {
        r: red as f32,
        g: green as f32,
        b: blue as f32,
        a: 1.0,
    };
    // One namespace per part: ids must be unique within a namespace.
    let part = |(part, (shape, [x, y, z], at)): (i32, (i32, [f64; 3], Isometry3<f64>))| Marker {
        ns: format!("{kind}/{part}"),
        id,
        kind: shape,
        action: Marker::ADD,
        pose: of_isometry(&at),
        scale: Vector3 { x, y, z },
        color,
        ..Marker::default()
    };
    (0..).zip(parts).map(part).collect()
}

fn of_pose(pose: &CellPose) -> Pose {
    let [x, y, z] = pose.position;
    let [qw, qx, qy, qz] = pose.orientation_wxyz;
    Pose {
        position: Vector3 { x, y, z },
        orientation: Quaternion {
            x: qx,
            y: qy,
            z: qz,
            w: qw,
        },
    }
}

fn of_isometry(pose: &Isometry3<f64>) -> Pose {
    let (at, turn) = (pose.translation.vector, pose.rotation.quaternion());
    of_pose(&CellPose {
        position: at.into(),
        orientation_wxyz: [turn.w, turn.i, turn.j, turn.k],
    })
}

fn isometry(pose: &CellPose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(pose.position), turn)
}
