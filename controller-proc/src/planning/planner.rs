//! The answer to a request, as a pure function of it.
//!
//! A replay computes each plan again, in another process, and an arm moves
//! along the result without supervision. The risks, and the rules against them:
//!
//! - The answer depends on something that is not in the request, such as the time, a cache or
//!   an earlier request: the replay differs. So all state of [`Planner`] is either constant or
//!   set from the request, and the number of the request is the seed.
//! - A search without a result takes forever: it is bounded by iterations and by comparisons
//!   with solids, never by a clock (ADR 0019).
//! - The path touches an obstacle with a part of the arm that the spheres of its files leave
//!   out: the planner adds spheres for these parts, opens the fingers, and keeps 8 mm
//!   (ADR 0021).
//! - A path is longer than the checkpoint of the controller can hold: it counts as no path.
//!
//! A change of a constant here changes the paths, and with them the state hashes of all demos
//! that plan.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use cell_model::{Cell, Robot};
use ipc_types::arm::{NotReached, PATH_POINTS};
use nalgebra::{Isometry3, Vector3};
use plan::{
    Body, BodyError, BodySetup, Path, PlanError, Reason, Request, Scene, Settings, Tool, plan,
    plan_to_pose, reason,
};
use rmp::{CollisionSphere, JointLimits, ObstacleId, RmpFlow, TargetId};

use super::path_follower::PathFollower;
use super::request::{Ask, PlanRequest};
use crate::error::RmpFlowError;
use crate::surroundings::Among;

/// Largest number of waypoints of a path; a longer one counts as no path.
// A path is part of the checkpoint, which has room for 16 KiB.
pub(crate) const MAX_WAYPOINTS: usize = 32;
/// Largest number of random configurations of a search: some 100 ms if no path exists.
// Bounded by iterations, not by time, so that the answer does not depend on the machine (ADR
// 0019).
const MAX_ITERATIONS: u64 = 10_000;
/// Largest number of comparisons with solids.
// Bounds a scene with many solids, where an iteration takes longer.
const MAX_LOOKS: u64 = 20_000_000;

/// Largest distance of the tool from its straight line, on a straight line in joint space, for
/// which motion policies stay about as near to it (m).
const BOW_M: f64 = 0.15;
/// Distance of paths from obstacles (m): the spheres leave out parts that stick out by 4 mm.
// With the spheres of the files alone, paths with 15 mm of clearance touched the edge of a
// board with the corner of the hand (ADR 0021).
const PADDING_M: f64 = 0.008;

/// An arm for the planner: covered by spheres as a whole. Motion policies keep more distance,
/// and use the spheres of the robot's files, which leave out parts of it.
#[derive(Debug)]
pub(crate) struct PlannedArm {
    robot: Robot,
    /// The arm with the spheres of its files.
    plain: Arc<Body>,
    /// With all spheres. They take some 20 ms to compute, so only when they are needed.
    covered: OnceLock<Arc<Body>>,
}

impl PlannedArm {
    /// The arm of `robot`.
    ///
    /// # Errors
    /// If the robot's files contradict each other.
    pub(crate) fn new(robot: &Robot) -> Result<Self, RmpFlowError> {
        let plain = Self::with(robot, &robot.spheres).map_err(|source| RmpFlowError::Planner {
            robot: robot.name.clone(),
            source,
        })?;
        Ok(Self {
            robot: robot.clone(),
            plain: Arc::new(plain),
            covered: OnceLock::new(),
        })
    }

    fn with(robot: &Robot, spheres: &[CollisionSphere]) -> Result<Body, BodyError> {
        let names = robot.chain.joints().iter().map(|joint| joint.name.clone());
        let mut defaults: BTreeMap<String, f64> = names
            .zip(robot.fixed_joint_positions.iter().copied())
            .collect();
        // Open fingers take the most room.
        if let Some(gripper) = &robot.gripper {
            for joint in gripper.finger_joints {
                if let Some(joint) = robot.chain.joints().get(joint) {
                    defaults.insert(joint.name.clone(), 0.5 * gripper.max_width);
                }
            }
        }
        Body::new(&BodySetup {
            chain: &robot.chain,
            joint_names: &robot.arm_joint_names(),
            default_positions: &defaults,
            spheres,
            self_spheres: &robot.self_spheres,
            self_ignore: &robot.self_ignore,
            tool: robot.tcp_frame_name(),
        })
    }

    fn covered(&self) -> &Arc<Body> {
        self.covered.get_or_init(|| {
            let mut spheres = self.robot.spheres.clone();
            spheres.extend(self.robot.uncovered_spheres());
            // The plain body was accepted, and the added spheres are on links, so this does
            // not fail.
            Self::with(&self.robot, &spheres).map_or_else(|_| self.plain.clone(), Arc::new)
        })
    }

    pub(crate) fn joint_count(&self) -> usize {
        self.plain.joint_count()
    }

    /// The arm with the spheres `held` on its tool.
    pub(crate) fn body(&self, held: &[(Vector3<f64>, f64)]) -> Arc<Body> {
        if held.is_empty() {
            return Arc::clone(self.covered());
        }
        Arc::new(self.covered().carrying(held))
    }

    /// Settings of a search; another seed tries other configurations.
    pub(crate) fn settings(seed: u64) -> Settings {
        Settings {
            seed,
            max_iterations: MAX_ITERATIONS,
            max_looks: MAX_LOOKS,
            padding: PADDING_M,
            ..Settings::default()
        }
    }
}

/// An answer.
#[derive(Debug)]
pub struct PlanAnswer {
    /// Number of its request.
    pub id: u64,
    /// Reason why no path was found; none if there is one or none is needed.
    pub not_reached: NotReached,
    pub(crate) follower: Option<PathFollower>,
}

/// Answers the requests of one arm: equal requests have equal answers, to the bit, in bounded
/// time.
pub struct Planner {
    arm: PlannedArm,
    /// For its kinematics and its obstacles.
    flow: RmpFlow,
    tool: TargetId,
    limits: JointLimits,
    base: Isometry3<f64>,
    /// Capacity of solids.
    capacity: usize,
}

impl Planner {
    /// The planner of arm `arm` of `cell`.
    ///
    /// # Errors
    /// [`RmpFlowError`] if the cell has no arm of this number, or the robot's files contradict
    /// each other.
    pub fn new(cell: &Cell, arm: usize) -> Result<Self, RmpFlowError> {
        let spec = cell.arms.get(arm).ok_or(RmpFlowError::NoSuchArm(arm))?;
        let robot = &spec.robot;
        let among = Among::new(cell, arm, spec)?;
        Ok(Self {
            arm: PlannedArm::new(robot)?,
            flow: among.flow,
            tool: among.tool,
            limits: robot.limits(),
            base: spec.base,
            capacity: among.capacity,
        })
    }

    /// The answer to `request`; depends on nothing else.
    pub fn answer(&mut self, request: &PlanRequest) -> PlanAnswer {
        let (not_reached, follower) = match self.solve(request) {
            Ok(follower) => (NotReached::None, follower),
            Err(reason) => (reason, None),
        };
        PlanAnswer {
            id: request.id,
            not_reached,
            follower,
        }
    }

    /// A path, or `None` if motion policies can move straight to the goal.
    fn solve(&mut self, request: &PlanRequest) -> Result<Option<PathFollower>, NotReached> {
        let scene = self.scene(request);
        let body = self.arm.body(&request.held);
        // The number is the seed: a later request for the same goal tries other
        // configurations.
        let settings = PlannedArm::settings(request.id);
        let wanted = Request {
            body: &body,
            scene: &scene,
            start: &request.start,
            posture: &request.posture,
            goal: &request.goal,
        };
        let mut tool = Tool::new(&mut self.flow, self.tool, &self.limits);
        // The reason alone: for an arm whose cell has no planner.
        if request.ask == Ask::Reason {
            return Err(named(reason(&wanted, &mut tool, &settings)));
        }
        let path = if request.by_joints {
            plan(&body, &scene, &request.start, &request.posture, &settings)
        } else {
            plan_to_pose(&wanted, &mut tool, &settings)
        };
        let path = path.map_err(|error| match error {
            PlanError::InCollision { what: "start" } => NotReached::InCollision,
            PlanError::Unreachable { .. } => named(reason(&wanted, &mut tool, &settings)),
            PlanError::Configuration { .. } => NotReached::JointLimit,
            PlanError::Pose => NotReached::Unreachable,
            PlanError::InCollision { .. } | PlanError::NotFound { .. } => NotReached::Blocked,
        })?;
        if path.waypoints.len() > MAX_WAYPOINTS {
            return Err(NotReached::Blocked);
        }
        let points = self.points(&path);
        // Motion policies move the tool straight; with joints as the goal the arm would leave
        // the line.
        let is_straight = path.iterations == 0 && !request.by_joints && bow(&points) < BOW_M;
        if is_straight && request.ask == Ask::Path {
            return Ok(None);
        }
        let (held, capacity) = (request.held.clone(), self.capacity);
        Ok(Some(PathFollower::new(
            &path, body, held, &points, capacity,
        )))
    }

    /// The obstacles of the request, at their places.
    fn scene(&mut self, request: &PlanRequest) -> Scene {
        let set = self.flow.obstacles_mut();
        let mut scene = Scene::with_capacity(set.len());
        for id in (0..set.len()).map(ObstacleId) {
            // Obstacles that are not in the request are switched off: they were not in force
            // in its tick.
            let asked = request.obstacles.iter().find(|(asked, _)| *asked == id.0);
            // The number is known, and a pose that is not finite was refused before.
            let placed = asked.is_some_and(|(_, pose)| set.set_pose(id, *pose).is_ok());
            let _known = set.set_enabled(id, placed).is_ok();
        }
        scene.set(set.enabled());
        scene
    }

    /// The tool at evenly spaced points of `path`, in the world frame (m).
    fn points(&mut self, path: &Path) -> [[f64; 3]; PATH_POINTS] {
        let mut points = [[0.0; 3]; PATH_POINTS];
        for (index, point) in points.iter_mut().enumerate() {
            let at = path.at(index as f64 / (PATH_POINTS - 1) as f64);
            if let Ok(Some(pose)) = self.flow.target_frame_pose_at(self.tool, &at) {
                *point = (self.base * pose).translation.vector.into();
            }
        }
        points
    }
}

/// Largest distance of `points` from the line from the first to the last (m).
fn bow(points: &[[f64; 3]]) -> f64 {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return 0.0;
    };
    let first = Vector3::from(*first);
    let along = Vector3::from(*last) - first;
    let off = |point: &[f64; 3]| {
        let from = Vector3::from(*point) - first;
        let part = from.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
        (from - along * part.clamp(0.0, 1.0)).norm()
    };
    points.iter().map(off).fold(0.0, f64::max)
}

fn named(reason: Reason) -> NotReached {
    match reason {
        Reason::Unreachable => NotReached::Unreachable,
        Reason::JointLimit => NotReached::JointLimit,
        Reason::Blocked => NotReached::Blocked,
        Reason::Singular => NotReached::Singular,
        Reason::LocalMinimum => NotReached::LocalMinimum,
    }
}
