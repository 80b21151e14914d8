//! The case file, and the controller it describes.

use std::collections::BTreeMap;
use std::path::Path;

use cell_model::data::read_text;
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use rmp::{JointLimits, MotionState, Obstacle, RmpFlow, RmpFlowSetup, SetupError, TargetId};
use serde::Deserialize;

const MOST_STEPS: u32 = 10_000_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Case {
    urdf: String,
    xrdf: String,
    rmpflow: String,
    #[serde(default)]
    target_frames: Vec<String>,
    #[serde(default)]
    obstacles: Vec<Shape>,
    #[serde(default)]
    cspace_target: Option<Vec<f64>>,
    q: Vec<f64>,
    qd: Vec<f64>,
    #[serde(default)]
    targets: Vec<Target>,
    #[serde(default)]
    target_motion: Option<Motion>,
    pub(crate) resolve: Resolve,
    pub(crate) steps: u32,
    pub(crate) dt: f64,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Resolve {
    Exact,
    Cell,
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
enum Shape {
    Sphere {
        radius: f64,
        position: [f64; 3],
    },
    Cuboid {
        side_lengths: [f64; 3],
        position: [f64; 3],
        #[serde(default)]
        orientation_wxyz: Option<[f64; 4]>,
    },
    Capsule {
        pt1: [f64; 3],
        pt2: [f64; 3],
        radius: f64,
    },
    /// Along z.
    Cylinder {
        radius: f64,
        height: f64,
        position: [f64; 3],
        #[serde(default)]
        orientation_wxyz: Option<[f64; 4]>,
    },
    /// Along z, with its tip in that direction; `position` is the middle of its height.
    Cone {
        radius: f64,
        height: f64,
        position: [f64; 3],
        #[serde(default)]
        orientation_wxyz: Option<[f64; 4]>,
    },
    ConvexHull {
        points: Vec<[f64; 3]>,
        position: [f64; 3],
        #[serde(default)]
        orientation_wxyz: Option<[f64; 4]>,
    },
}

impl Shape {
    fn obstacle(&self) -> Result<Obstacle, String> {
        Ok(match self {
            Self::Sphere { radius, position } => Obstacle::sphere((*position).into(), *radius),
            Self::Capsule { pt1, pt2, radius } => {
                Obstacle::capsule((*pt1).into(), (*pt2).into(), *radius)
            }
            Self::Cuboid {
                side_lengths,
                position,
                orientation_wxyz,
            } => Obstacle::cuboid(
                pose(position, orientation_wxyz.as_ref())?,
                (*side_lengths).into(),
            ),
            Self::Cylinder {
                radius,
                height,
                position,
                orientation_wxyz,
            } => Obstacle::cylinder(pose(position, orientation_wxyz.as_ref())?, *radius, *height),
            Self::Cone {
                radius,
                height,
                position,
                orientation_wxyz,
            } => Obstacle::cone(pose(position, orientation_wxyz.as_ref())?, *radius, *height),
            Self::ConvexHull {
                points,
                position,
                orientation_wxyz,
            } => {
                let points: Vec<Vector3<f64>> = points.iter().map(|p| (*p).into()).collect();
                let hull = Obstacle::hull(pose(position, orientation_wxyz.as_ref())?, &points);
                hull.map_err(|error| error.to_string())?
            }
        })
    }
}

fn pose(position: &[f64; 3], turn: Option<&[f64; 4]>) -> Result<Isometry3<f64>, String> {
    let turn = orientation("orientation_wxyz", turn.unwrap_or(&[1.0, 0.0, 0.0, 0.0]))?;
    Ok(Isometry3::from_parts(Vector3::from(*position).into(), turn))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    frame: String,
    #[serde(default)]
    position: Option<[f64; 3]>,
    #[serde(default)]
    orientation_wxyz: Option<[f64; 4]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Motion {
    frame: String,
    axis: usize,
    amplitude: f64,
    rate: f64,
}

/// A controller ready to step.
pub(crate) struct Problem {
    pub(crate) flow: RmpFlow,
    pub(crate) limits: JointLimits,
    pub(crate) state: MotionState,
    pub(crate) frames: BTreeMap<String, TargetId>,
    moving: Option<(TargetId, Vector3<f64>)>,
}

impl Case {
    pub(crate) fn read(path: &str) -> Result<Self, String> {
        let text = read_text(Path::new(path)).map_err(|e| e.to_string())?;
        let case: Self = serde_json::from_str(&text).map_err(|e| format!("{path}: {e}"))?;
        if case.steps > MOST_STEPS {
            return Err(format!(
                "{path}: steps is {}; 0 to {MOST_STEPS} is allowed",
                case.steps
            ));
        }
        if !(case.dt > 0.0 && case.dt <= 1.0) {
            return Err(format!(
                "{path}: dt is {} s; above 0 to 1 is allowed",
                case.dt
            ));
        }
        Ok(case)
    }

    pub(crate) fn build(&self, path: &str) -> Result<Problem, String> {
        let at = |error: &dyn std::fmt::Display| format!("{path}: {error}");
        let (mut flow, limits) = self.controller().map_err(|e| at(&e))?;
        self.place_obstacles(&mut flow).map_err(|e| at(&e))?;
        if let Some(posture) = &self.cspace_target {
            flow.set_posture(posture)
                .map_err(|e| at(&format!("cspace_target: {e}")))?;
        }
        let frames = self.add_frames(&mut flow).map_err(|e| at(&e))?;
        for target in &self.targets {
            set_target(&mut flow, &frames, target).map_err(|e| at(&e))?;
        }
        let moving = self.moving(&frames).map_err(|e| at(&e))?;
        flow.evaluate(&self.q, &self.qd)
            .map_err(|e| at(&format!("q, qd: {e}")))?;
        let mut state = MotionState::at_rest(&self.q);
        state.velocities.copy_from_slice(&self.qd);
        Ok(Problem {
            flow,
            limits,
            state,
            frames,
            moving,
        })
    }

    fn controller(&self) -> Result<(RmpFlow, JointLimits), String> {
        let read = |file: &String| read_text(Path::new(file)).map_err(|e| e.to_string());
        let urdf = cell_model::robots::urdf::parse(&self.urdf, &read(&self.urdf)?)
            .map_err(|e| e.to_string())?;
        let xrdf = cell_model::robots::xrdf::parse(&self.xrdf, &read(&self.xrdf)?)
            .map_err(|e| e.to_string())?;
        let parameters = cell_model::robots::rmpflow::parse(&self.rmpflow, &read(&self.rmpflow)?)
            .map_err(|e| e.to_string())?;
        let flow = RmpFlow::new(&RmpFlowSetup {
            chain: &urdf.chain,
            joint_names: &xrdf.joint_names,
            default_positions: &xrdf.default_joint_positions,
            spheres: &xrdf.world_spheres,
            self_collision: rmp::SelfCollisionSetup {
                spheres: &xrdf.self_spheres,
                ignore: &xrdf.self_ignore,
            },
            parameters: &parameters,
            obstacle_capacity: self.obstacles.len(),
        })
        .map_err(|e| e.to_string())?;
        let joints = urdf.chain.joints();
        let named: Vec<usize> = xrdf
            .joint_names
            .iter()
            .filter_map(|name| urdf.chain.joint_index(name))
            .collect();
        let limits = JointLimits {
            lower: named.iter().map(|&j| joints[j].lower).collect(),
            upper: named.iter().map(|&j| joints[j].upper).collect(),
            velocity: named.iter().map(|&j| urdf.limits[j].velocity).collect(),
            acceleration: xrdf.acceleration_limits,
            jerk: xrdf.jerk_limits,
        };
        Ok((flow, limits))
    }

    fn place_obstacles(&self, flow: &mut RmpFlow) -> Result<(), String> {
        for (index, shape) in self.obstacles.iter().enumerate() {
            let key = format!("obstacles[{index}]");
            let obstacle = shape.obstacle().map_err(|e| format!("{key}: {e}"))?;
            flow.obstacles_mut()
                .add(obstacle)
                .map_err(|e| format!("{key}: {e}"))?;
        }
        Ok(())
    }

    fn add_frames(&self, flow: &mut RmpFlow) -> Result<BTreeMap<String, TargetId>, String> {
        let mut frames = BTreeMap::new();
        for name in &self.target_frames {
            let id = flow.add_target_frame(name).map_err(|e| e.to_string())?;
            if frames.insert(name.clone(), id).is_some() {
                return Err(format!("target_frames lists '{name}' twice"));
            }
        }
        Ok(frames)
    }

    fn moving(
        &self,
        frames: &BTreeMap<String, TargetId>,
    ) -> Result<Option<(TargetId, Vector3<f64>)>, String> {
        let Some(motion) = &self.target_motion else {
            return Ok(None);
        };
        let id = frame_id(frames, &motion.frame, "target_motion.frame")?;
        if motion.axis > 2 {
            return Err(format!(
                "target_motion.axis is {}; 0, 1 or 2 is allowed",
                motion.axis
            ));
        }
        let start = self
            .targets
            .iter()
            .rfind(|target| target.frame == motion.frame);
        match start.and_then(|target| target.position) {
            Some(position) => Ok(Some((id, position.into()))),
            None => Err(format!(
                "target_motion moves '{}', which has no position in targets; give it one",
                motion.frame
            )),
        }
    }
}

impl Problem {
    /// Sets the moving coordinate for step `k`.
    pub(crate) fn move_target(&mut self, case: &Case, k: u32) -> Result<(), SetupError> {
        if let (Some(motion), Some((id, position))) = (&case.target_motion, &mut self.moving) {
            let time = f64::from(k) * case.dt;
            position[motion.axis] = motion.amplitude * libm::sin(motion.rate * time);
            self.flow.set_position_target(*id, Some(*position))?;
        }
        Ok(())
    }
}

fn set_target(
    flow: &mut RmpFlow,
    frames: &BTreeMap<String, TargetId>,
    target: &Target,
) -> Result<(), String> {
    let id = frame_id(frames, &target.frame, "targets")?;
    let turn = match &target.orientation_wxyz {
        Some(wxyz) => Some(orientation(
            &format!("targets, frame '{}'", target.frame),
            wxyz,
        )?),
        None => None,
    };
    flow.set_position_target(id, target.position.map(Vector3::from))
        .and_then(|()| flow.set_orientation_target(id, turn))
        .map_err(|e| format!("targets, frame '{}': {e}", target.frame))
}

fn frame_id(
    frames: &BTreeMap<String, TargetId>,
    name: &str,
    key: &str,
) -> Result<TargetId, String> {
    frames
        .get(name)
        .copied()
        .ok_or_else(|| format!("{key} names '{name}', which target_frames does not list"))
}

/// A unit quaternion from any of sensible length.
fn orientation(key: &str, wxyz: &[f64; 4]) -> Result<UnitQuaternion<f64>, String> {
    let [w, x, y, z] = *wxyz;
    let raw = Quaternion::new(w, x, y, z);
    let length = raw.norm();
    if length.is_finite() && length > 1e-6 {
        Ok(UnitQuaternion::from_quaternion(raw))
    } else {
        Err(format!(
            "{key}: orientation_wxyz {wxyz:?} has no direction; give a unit quaternion"
        ))
    }
}
