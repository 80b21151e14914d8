//! An arm that follows a path.

use std::sync::Arc;

use ipc_types::arm::PATH_POINTS;
use nalgebra::Vector3;
use plan::{Ahead, Body, Guide, Path, Scene};

use super::goal::PlanGoal;
use super::planner::{MAX_WAYPOINTS, PlannedArm};
use super::request::held;
use crate::checkpoint::{CheckpointError, Codec};

/// Distance from obstacles to which corners are cut (m).
// Less than the 8 mm of a path, so that shorter ways across its corners are free (ADR 0021).
const CORNER_M: f64 = 0.006;
/// Largest lead of an arm that holds something (rad and m alike): a larger lead is a faster
/// motion, in which it would lose the object.
const HELD_AHEAD: f64 = 0.4;
/// If motion policies make the last part alone, the path ends this near to its last point (rad
/// and m alike).
const AT_APPROACH: f64 = 0.15;

/// A path, and the position of the arm on it.
#[derive(Debug)]
pub(crate) struct PathFollower {
    pub(crate) guide: Guide,
    /// The tool at evenly spaced points of the path, world frame (m).
    pub(crate) points: [[f64; 3]; PATH_POINTS],
    /// Spheres of the held object at the time of planning: centre in the tool frame, radius
    /// (m).
    held: Vec<(Vector3<f64>, f64)>,
}

impl PathFollower {
    /// On `path` of `body`, among at most `capacity` obstacles.
    pub(crate) fn new(
        path: &Path,
        body: Arc<Body>,
        held: Vec<(Vector3<f64>, f64)>,
        points: &[[f64; 3]; PATH_POINTS],
        capacity: usize,
    ) -> Self {
        let scene = Scene::with_capacity(capacity);
        let settings = PlannedArm::settings(0);
        let mut ahead = Ahead {
            padding: CORNER_M,
            ..Ahead::default()
        };
        if !held.is_empty() {
            ahead.most = HELD_AHEAD;
        }
        Self {
            guide: Guide::new(body, scene, path, &settings, ahead),
            points: *points,
            held,
        }
    }

    /// Positions to lead an arm at `positions` to, and whether they are the end of the path.
    pub(crate) fn lead(&mut self, positions: &[f64]) -> (&[f64], bool) {
        // The guide's answer borrows it whole.
        let sees_the_end = self.guide.sees_the_end();
        (self.guide.lead(positions), sees_the_end)
    }

    /// Whether the arm is at the end of the path, from which motion policies reach `goal`
    /// alone.
    pub(crate) fn is_done(&self, goal: &PlanGoal, positions: &[f64]) -> bool {
        // Without waypoints nothing is left to follow.
        let Some(end) = self.guide.waypoints().last() else {
            return true;
        };
        let off = end.iter().zip(positions).map(|(a, b)| (a - b) * (a - b));
        goal.ends_alone() && off.sum::<f64>() < AT_APPROACH * AT_APPROACH
    }

    /// Writes `follower`, or reads it.
    pub(crate) fn checkpoint(
        follower: &mut Option<Self>,
        codec: &mut Codec<'_>,
        arm: &PlannedArm,
        capacity: usize,
    ) -> Result<(), CheckpointError> {
        let (mut waypoints, mut memory) = (Vec::new(), (0.0, 0.0));
        let (mut spheres, mut points) = (Vec::new(), [[0.0; 3]; PATH_POINTS]);
        if codec.reads() {
            // Read and written in one order of fields. The guide is rebuilt from the
            // waypoints.
            read(codec, arm.joint_count(), &mut waypoints)?;
        } else if let Some(follower) = follower {
            write(codec, follower.guide.waypoints())?;
            (memory, points) = (follower.guide.memory(), follower.points);
            held(codec, &mut follower.held)?;
        }
        if codec.reads() {
            held(codec, &mut spheres)?;
        }
        codec.f64(&mut memory.0)?;
        codec.f64(&mut memory.1)?;
        codec.f64s(points.as_flattened_mut())?;
        if codec.reads() {
            let path = Path {
                waypoints,
                length: 0.0,
                iterations: 0,
            };
            let mut read = Self::new(&path, arm.body(&spheres), spheres, &points, capacity);
            read.guide.set_memory(memory);
            *follower = Some(read);
        }
        Ok(())
    }
}

fn write(codec: &mut Codec<'_>, waypoints: &[Vec<f64>]) -> Result<(), CheckpointError> {
    let mut count = waypoints.len();
    codec.index("waypoints", &mut count, MAX_WAYPOINTS + 1)?;
    for position in waypoints.iter().flatten() {
        let mut position = *position;
        codec.f64(&mut position)?;
    }
    Ok(())
}

fn read(
    codec: &mut Codec<'_>,
    joints: usize,
    waypoints: &mut Vec<Vec<f64>>,
) -> Result<(), CheckpointError> {
    let mut count = 0;
    codec.index("waypoints", &mut count, MAX_WAYPOINTS + 1)?;
    waypoints.resize(count, vec![0.0; joints]);
    codec.f64s(waypoints.iter_mut().flatten())
}
