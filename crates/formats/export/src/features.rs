//! The numbers of a frame, by the names of their features.

use cell_model::Cell;
use ipc_types::WorldState;
use ipc_types::world::OBJECT_ENABLED;

use crate::episode::Episode;

/// A vector of each frame.
pub(crate) struct Vectors {
    /// Name of the feature.
    pub(crate) key: &'static str,
    /// Names of its numbers.
    pub(crate) names: Vec<String>,
    /// One after the other, frame by frame.
    pub(crate) numbers: Vec<f32>,
}

const POSE: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

/// All vectors of an episode.
pub(crate) fn vectors(episode: &Episode) -> Vec<Vectors> {
    let cell = &episode.cell;
    let states = || episode.frames.iter().map(|frame| &*frame.state);
    // The state after each action: what its setpoints led to.
    let after = states().skip(1).chain([&*episode.end]);
    vec![
        Vectors {
            key: "observation.state",
            names: arm_names(cell),
            numbers: states().flat_map(|state| arms(cell, state)).collect(),
        },
        Vectors {
            key: "observation.environment_state",
            names: object_names(cell),
            numbers: states().flat_map(|state| objects(cell, state)).collect(),
        },
        Vectors {
            key: "action",
            names: action_names(cell),
            numbers: episode
                .frames
                .iter()
                .flat_map(|frame| frame.action.iter().flatten().copied())
                .collect(),
        },
        Vectors {
            key: "setpoint_positions",
            names: joint_names(cell),
            numbers: after.flat_map(|state| setpoints(cell, state)).collect(),
        },
    ]
}

fn joint_names(cell: &Cell) -> Vec<String> {
    let arms = cell.arms.iter();
    arms.flat_map(|arm| {
        let count = arm.robot.arm_joints.len();
        (1..=count).map(move |joint| format!("{}.joint_{joint}", arm.name))
    })
    .collect()
}

fn arm_names(cell: &Cell) -> Vec<String> {
    let arms = cell.arms.iter();
    arms.flat_map(|arm| {
        let joints = (1..=arm.robot.arm_joints.len()).map(|joint| format!("joint_{joint}"));
        let tcp = POSE.iter().map(|name| format!("tcp_{name}"));
        let gripper = ["gripper_width", "held"].map(str::to_owned);
        let names = joints.chain(tcp).chain(gripper);
        names.map(move |name| format!("{}.{name}", arm.name))
    })
    .collect()
}

fn action_names(cell: &Cell) -> Vec<String> {
    let arms = cell.arms.iter();
    arms.flat_map(|arm| {
        let names = POSE.iter().copied().chain(["gripper"]);
        names.map(move |name| format!("{}.{name}", arm.name))
    })
    .collect()
}

fn object_names(cell: &Cell) -> Vec<String> {
    let objects = cell.objects.iter();
    objects
        .flat_map(|object| POSE.map(|name| format!("{}.{name}", object.name)))
        .collect()
}

fn setpoints(cell: &Cell, state: &WorldState) -> Vec<f32> {
    let arms = cell.arms.iter().zip(state.arms());
    arms.flat_map(|(arm, seen)| {
        let count = arm.robot.arm_joints.len();
        seen.setpoint_positions.into_iter().take(count)
    })
    .map(single)
    .collect()
}

/// The numbers of `observation.state`.
pub(crate) fn arms(cell: &Cell, state: &WorldState) -> Vec<f32> {
    let arms = cell.arms.iter().zip(state.arms());
    arms.flat_map(|(arm, seen)| {
        let joints = seen.joint_positions.into_iter();
        let joints = joints.take(arm.robot.arm_joints.len());
        let held = f64::from(u8::from(seen.gripper.held_object > 0));
        joints
            .chain(seen.tcp.position)
            .chain(seen.tcp.orientation_wxyz)
            .chain([seen.gripper.width, held])
    })
    .map(single)
    .collect()
}

/// Poses of the objects; zeros for one that is not in the cell.
fn objects(cell: &Cell, state: &WorldState) -> Vec<f32> {
    let objects = state.objects.iter().take(cell.objects.len());
    objects
        .flat_map(|object| {
            let is_there = object.flags & OBJECT_ENABLED != 0;
            let pose = object.pose.position.into_iter();
            let pose = pose.chain(object.pose.orientation_wxyz);
            pose.map(move |number| if is_there { single(number) } else { 0.0 })
        })
        .collect()
}

#[allow(clippy::cast_possible_truncation, reason = "rounds")]
fn single(number: f64) -> f32 {
    number as f32
}
