//! Paths to a pose of the tool.

use nalgebra::Isometry3;

use crate::check::{Checker, distance};
use crate::ik::{Found, Tool};
use crate::planner::{Path, PlanError, Settings, plan};
use crate::{Body, Scene, halton};

/// Configurations from which the pose is tried: the start, the posture, and others spread over
/// the limits.
const STARTS: u64 = 24;
/// Number of free configurations with the pose, after which the search for them ends.
// Each is a goal that costs a search; those nearest to the start are planned first.
const ENOUGH: usize = 4;

/// The position of an arm, and the goal of its tool.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The arm.
    pub body: &'a Body,
    /// The solids around it.
    pub scene: &'a Scene,
    /// Its position, within its limits (rad or m).
    pub start: &'a [f64],
    /// Preferred joint positions (rad or m).
    pub posture: &'a [f64],
    /// Pose of the tool, base frame (m).
    pub goal: &'a Isometry3<f64>,
}

impl Request<'_> {
    /// Starts of the search for joint positions.
    pub(crate) fn starts(&self, settings: &Settings) -> impl Iterator<Item = Vec<f64>> {
        let (body, seed) = (self.body, settings.seed);
        let anywhere = move |index: u64| -> Vec<f64> {
            let limits = body.lower.iter().zip(&body.upper).enumerate();
            let part = |joint: usize| halton::value(seed.wrapping_add(index), joint);
            let position =
                |(joint, (low, high)): (usize, (&f64, &f64))| low + part(joint) * (high - low);
            limits.map(position).collect()
        };
        let near = [self.start.to_vec(), self.posture.to_vec()];
        near.into_iter().chain((2..STARTS).map(anywhere))
    }
}

/// A path to a configuration in which the tool is at the goal: of those found, the nearest one
/// to the start to which a path leads.
///
/// # Errors
/// [`PlanError`]: the pose is not finite or out of reach, every configuration found with it is
/// in collision, the start is invalid or in collision, or no path was found.
pub fn plan_to_pose(
    request: &Request<'_>,
    tool: &mut Tool<'_>,
    settings: &Settings,
) -> Result<Path, PlanError> {
    let Request {
        body, scene, start, ..
    } = *request;
    let mut goals = configurations(request, tool, settings)?;
    goals.sort_by(|a, b| distance(a, start).total_cmp(&distance(b, start)));
    let mut failed = PlanError::InCollision { what: "goal" };
    for goal in &goals {
        match plan(body, scene, start, goal, settings) {
            Ok(path) => return Ok(path),
            // An invalid start fails for every goal.
            Err(error @ (PlanError::Configuration { .. } | PlanError::InCollision { .. })) => {
                return Err(error);
            }
            Err(error) => failed = error,
        }
    }
    Err(failed)
}

/// Free configurations with the pose; empty if all that were found are in collision.
fn configurations(
    request: &Request<'_>,
    tool: &mut Tool<'_>,
    settings: &Settings,
) -> Result<Vec<Vec<f64>>, PlanError> {
    if !request.goal.to_homogeneous().iter().all(|x| x.is_finite()) {
        return Err(PlanError::Pose);
    }
    let mut checker = Checker::new(request.body, request.scene, settings.resolution);
    let mut nearest: Option<Found> = None;
    let (mut free, mut met) = (Vec::new(), false);
    for start in request.starts(settings) {
        match tool.solve(&start, request.goal) {
            // Met and in collision is a failure, but it proves that the pose can be reached.
            Some(found) if found.is_met() => {
                met = true;
                if checker.is_free(&found.positions) {
                    free.push(found.positions);
                }
            }
            Some(found) => nearest = Some(Found::nearer(nearest, found)),
            None => {}
        }
        if free.len() == ENOUGH {
            break;
        }
    }
    // Unreachable only if no start met the pose, free or not.
    match nearest {
        Some(found) if !met => Err(PlanError::Unreachable {
            off_m: found.off_m,
            off_rad: found.off_rad,
        }),
        _ => Ok(free),
    }
}
