//! The grasps of an object in the state of a cell, for people and programs.

use cell_model::Cell;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{Pose, WorldState};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

use crate::{Candidate, Exclusion, Grasps, Gripper, Reach, Scene, grasps};

/// The grasps of an object.
#[derive(Debug, Serialize, JsonSchema)]
pub struct GraspReport {
    /// Name of the arm.
    pub arm: String,
    /// Name of the object.
    pub object: String,
    /// Best first; those that are excluded are last.
    pub candidates: Vec<GraspRow>,
    /// Why there is none: `too_wide`, `too_thin`, `cup_larger_than_face`, `no_room_for_fingers`,
    /// `blocked_by_fixture`, `blocked_by_object`, `blocked_by_arm` or `object_out_of_reach`.
    pub reason: Option<&'static str>,
    /// The same with names and numbers.
    pub message: Option<String>,
}

/// A candidate.
#[derive(Debug, Serialize, JsonSchema)]
pub struct GraspRow {
    /// `above`, `oblique` or `side`.
    pub approach: &'static str,
    /// `centre`, `low`, `upper part` or `face`.
    pub depth: &'static str,
    /// TCP in the world frame.
    pub tcp: TcpPose,
    /// Turn of the direction in which the fingers close, about the vertical (rad, 0 to pi).
    pub yaw_rad: f64,
    /// Width of the object between the fingers, of the face for a cup (m).
    pub width_m: f64,
    /// The smaller, the better.
    pub cost: f64,
    /// As `reason` of the whole; missing for a grasp.
    pub excluded: Option<&'static str>,
    /// The same with names and numbers.
    pub why: Option<String>,
}

/// Position (m) and orientation in the world frame.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TcpPose {
    /// Position (m).
    pub position: [f64; 3],
    /// Quaternion w, x, y, z.
    pub orientation_wxyz: [f64; 4],
}

impl GraspReport {
    /// All grasps of an object by an arm, by index, in the scene of `state`. Each pose is searched
    /// for in the inverse kinematics, so this takes up to seconds.
    ///
    /// # Errors
    /// A sentence for people: for an arm that the cell does not have, and one without a gripper.
    pub fn of(cell: &Cell, state: &WorldState, object: usize, arm: usize) -> Result<Self, String> {
        let count = cell.arms.len();
        let spec = cell.arms.get(arm);
        let spec = spec.ok_or_else(|| format!("there is no arm {arm}; this cell has {count}"))?;
        let gripper = Gripper::of(&spec.robot);
        let gripper = gripper.ok_or_else(|| format!("arm '{}' has no gripper", spec.name))?;
        let scene = seen(cell, state, arm);
        let tool = state.arms().get(arm).map(|seen| isometry(&seen.tcp));
        let mut found = grasps(&gripper, &scene, object, tool.as_ref());
        // An arm whose files its controller refuses does not run.
        if let Some(mut reach) = Reach::of(spec) {
            found.ask_reach(|tcp| reach.reaches(tcp));
        }
        let name = cell.objects.get(object).map(|object| object.name.clone());
        Ok(Self::new(
            spec.name.clone(),
            name.unwrap_or_default(),
            &found,
        ))
    }

    fn new(arm: String, object: String, found: &Grasps) -> Self {
        let refusal = found.refusal();
        let missing = found.candidates.is_empty();
        let absent = missing.then(|| "the object is not in the cell".to_owned());
        Self {
            arm,
            object,
            candidates: found.candidates.iter().map(GraspRow::of).collect(),
            reason: refusal.map(Exclusion::reason),
            message: refusal.map(ToString::to_string).or(absent),
        }
    }
}

impl GraspRow {
    fn of(of: &Candidate) -> Self {
        let rotation = of.tcp.rotation;
        let across = rotation * Vector3::y();
        Self {
            approach: of.approach.name(),
            depth: of.depth.name(),
            tcp: TcpPose {
                position: of.tcp.translation.vector.into(),
                orientation_wxyz: [rotation.w, rotation.i, rotation.j, rotation.k],
            },
            // Half a turn exchanges the fingers and gives the same grasp.
            yaw_rad: across.y.atan2(across.x).rem_euclid(std::f64::consts::PI),
            width_m: of.width_m,
            cost: of.cost,
            excluded: of.excluded.as_ref().map(Exclusion::reason),
            why: of.excluded.as_ref().map(ToString::to_string),
        }
    }
}

/// The bodies of a cell where `state` has them, without those of `arm` itself.
fn seen(cell: &Cell, state: &WorldState, arm: usize) -> Scene {
    let mut scene = Scene::of(cell);
    for (body, seen) in scene.objects.iter_mut().zip(state.objects()) {
        let is_here = seen.flags & OBJECT_ENABLED != 0;
        body.pose = is_here.then(|| isometry(&seen.pose));
    }
    let arms = cell.arms.iter().zip(state.arms()).enumerate();
    for (_, (spec, seen)) in arms.filter(|(other, _)| *other != arm) {
        let count = seen.joint_count as usize;
        scene.add_arm(spec, seen.joint_positions.get(..count).unwrap_or_default());
    }
    scene
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    Isometry3::from_parts(
        Translation3::from(pose.position),
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    )
}
