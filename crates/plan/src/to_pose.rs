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

/// A path of `body` in `scene` from `start` (rad or m) to a configuration in which the tool
/// is at `goal` (base frame): of some the one next to `start` that a path leads to. `posture`
/// is one that the arm likes (rad or m).
///
/// # Errors
/// [`PlanError`]: the pose is out of reach, every configuration found with it is in collision,
/// or no path leads there.
pub fn plan_to_pose(
    body: &Body,
    scene: &Scene,
    tool: &mut Tool<'_>,
    (start, posture): (&[f64], &[f64]),
    goal: &Isometry3<f64>,
    settings: &Settings,
) -> Result<Path, PlanError> {
    let mut goals = configurations(body, scene, tool, (start, posture), goal, settings)?;
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
    body: &Body,
    scene: &Scene,
    tool: &mut Tool<'_>,
    (start, posture): (&[f64], &[f64]),
    goal: &Isometry3<f64>,
    settings: &Settings,
) -> Result<Vec<Vec<f64>>, PlanError> {
    let mut checker = Checker::new(body, scene, settings.resolution);
    let mut nearest: Option<Found> = None;
    let mut free: Vec<Vec<f64>> = Vec::new();
    for from in starts(body, (start, posture), settings) {
        let Some(found) = tool.solve(&from, goal) else {
            continue;
        };
        if found.is_met() && checker.is_free(&found.positions) {
            free.push(found.positions.clone());
            if free.len() == ENOUGH {
                break;
            }
        }
        let is_nearer = |best: &Found| found.off_m + found.off_rad < best.off_m + best.off_rad;
        if nearest.as_ref().is_none_or(is_nearer) {
            nearest = Some(found);
        }
    }
    match nearest {
        Some(found) if !found.is_met() => Err(PlanError::Unreachable {
            off_m: found.off_m,
            off_rad: found.off_rad,
        }),
        Some(_) => Ok(free),
        None => Err(PlanError::Configuration {
            what: "start",
            joint: start.len(),
            position: f64::NAN,
        }),
    }
}

/// Where the search for joint positions begins.
pub(crate) fn starts<'a>(
    body: &'a Body,
    (start, posture): (&'a [f64], &'a [f64]),
    settings: &'a Settings,
) -> impl Iterator<Item = Vec<f64>> + 'a {
    (0..STARTS).map(move |index| match index {
        0 => start.to_vec(),
        1 => posture.to_vec(),
        _ => anywhere(body, settings.seed.wrapping_add(index)),
    })
}

fn anywhere(body: &Body, index: u64) -> Vec<f64> {
    let limits = body.lower.iter().zip(&body.upper).enumerate();
    limits
        .map(|(joint, (lower, upper))| lower + halton::value(index, joint) * (upper - lower))
        .collect()
}
