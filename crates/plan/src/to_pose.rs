//! Paths to a pose of the tool.

use nalgebra::Isometry3;

use crate::check::{Checker, distance};
use crate::ik::{Found, Tool};
use crate::planner::{Path, PlanError, Settings, plan};
use crate::{Body, Scene, halton};

/// Configurations from which the pose is tried: where the arm is, its posture, and others
/// anywhere.
const STARTS: u64 = 24;
/// Free configurations with the pose, after which no more are searched.
const ENOUGH: usize = 4;

/// Where an arm is, and where its tool is to be.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// The arm.
    pub body: &'a Body,
    /// What is around it.
    pub scene: &'a Scene,
    /// Where it is, within its limits (rad or m).
    pub start: &'a [f64],
    /// Joint positions it likes (rad or m).
    pub posture: &'a [f64],
    /// Pose of the tool, base frame (m).
    pub goal: &'a Isometry3<f64>,
}

impl Request<'_> {
    /// Where the search for joint positions begins.
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

/// A path to a configuration in which the tool is at the goal: of some the one next to the
/// start that a path leads to.
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
            // Another goal would not help.
            Err(error @ (PlanError::Configuration { .. } | PlanError::InCollision { .. })) => {
                return Err(error);
            }
            Err(error) => failed = error,
        }
    }
    Err(failed)
}

/// Free ones with the pose; none where those that have it are in collision.
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
    match nearest {
        Some(found) if !met => Err(PlanError::Unreachable {
            off_m: found.off_m,
            off_rad: found.off_rad,
        }),
        _ => Ok(free),
    }
}
