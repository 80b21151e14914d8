//! Two trees that grow towards each other.

use thiserror::Error;

use crate::body::Body;
use crate::check::{Checker, distance};
use crate::halton;
use crate::scene::{Scene, single};
use crate::shortcut::{length, shorten};
use crate::tree::Tree;

/// How a plan is searched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Which random configurations are tried.
    pub seed: u64,
    /// Random configurations at most.
    pub max_iterations: u64,
    /// Solids that are looked at, each with sixteen configurations of an edge, at most: what
    /// a search costs, however many there are.
    pub max_looks: u64,
    /// Length of an edge at most (rad, m).
    pub range: f64,
    /// Configurations that are checked for each rad (m) of an edge.
    pub resolution: f64,
    /// How far the spheres stay off the scene (m), where start and goal do: what moves between
    /// two configurations that are checked is within it.
    pub padding: f64,
    /// Attempts to cut a corner.
    pub shortcuts: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            max_iterations: 100_000,
            max_looks: 100_000_000,
            range: 1.5,
            resolution: 96.0,
            padding: 0.002,
            shortcuts: 60,
        }
    }
}

/// A way that touches nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// From start to goal, joined by straight lines in joint space.
    pub waypoints: Vec<Vec<f64>>,
    /// Length in joint space (rad and m alike).
    pub length: f64,
    /// Random configurations that were tried.
    pub iterations: u64,
}

impl Path {
    /// The configuration (rad or m) at a part of the length, 0 to 1; what is beyond is the
    /// start or the end. Empty where there is no waypoint.
    pub fn at(&self, part: f64) -> Vec<f64> {
        let mut left = part * length(&self.waypoints);
        for pair in self.waypoints.windows(2) {
            let long = distance(&pair[0], &pair[1]);
            if left < long {
                let part = (left / long).max(0.0);
                let joints = pair[0].iter().zip(&pair[1]);
                return joints.map(|(from, to)| from + part * (to - from)).collect();
            }
            left -= long;
        }
        self.waypoints.last().cloned().unwrap_or_default()
    }
}

/// Why there is no path.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// Start or goal has another number of joints, or a position that is not finite or
    /// outside of the limits of its joint.
    #[error(
        "the {what} is no configuration of the arm: joint {joint} is at {position}; a finite position within the limits of each joint is needed"
    )]
    Configuration {
        /// `start` or `goal`.
        what: &'static str,
        /// Index of the joint.
        joint: usize,
        /// Its position (rad or m); NaN where there is none.
        position: f64,
    },
    /// The arm touches something, or itself, already.
    #[error(
        "the {what} is in collision with the scene or with the arm itself; move the arm or the obstacle"
    )]
    InCollision {
        /// `start` or `goal`.
        what: &'static str,
    },
    /// The pose is no position with an orientation.
    #[error("the pose is not finite; give a position in m and a unit quaternion")]
    Pose,
    /// No configuration within the limits has the pose.
    #[error(
        "the pose is out of reach: the nearest configuration found is {off_m:.3} m and {off_rad:.3} rad off; move the target or the arm's base"
    )]
    Unreachable {
        /// m.
        off_m: f64,
        /// rad.
        off_rad: f64,
    },
    /// None was found: perhaps there is none.
    #[error("no path was found in {iterations} iterations; allow more, or choose another goal")]
    NotFound {
        /// Random configurations that were tried.
        iterations: u64,
    },
}

/// A path of `body` in `scene` from `start` to `goal` (rad or m).
///
/// # Errors
/// [`PlanError`] where an end is invalid or in collision, or no path was found.
pub fn plan(
    body: &Body,
    scene: &Scene,
    start: &[f64],
    goal: &[f64],
    settings: &Settings,
) -> Result<Path, PlanError> {
    let mut checker = Checker::new(body, scene, settings.resolution);
    for (what, end) in [("start", start), ("goal", goal)] {
        check_end(body, what, end)?;
        if !checker.is_free(end) {
            return Err(PlanError::InCollision { what });
        }
    }
    checker.padding = padding(&mut checker, &[start, goal], settings.padding);
    let (mut waypoints, iterations) = if checker.is_edge_free(start, goal) {
        (vec![start.to_vec(), goal.to_vec()], 0)
    } else {
        search(body, &mut checker, start, goal, settings)?
    };
    shorten(
        &mut waypoints,
        &mut checker,
        settings.shortcuts,
        settings.seed,
    );
    Ok(Path {
        length: length(&waypoints),
        waypoints,
        iterations,
    })
}

/// The padding, or the part of it that both ends keep.
fn padding(checker: &mut Checker<'_>, ends: &[&[f64]; 2], wanted: f64) -> f32 {
    for part in [1.0, 0.5, 0.25] {
        checker.padding = single(part * wanted);
        if ends.iter().all(|end| checker.is_free(end)) {
            return checker.padding;
        }
    }
    0.0
}

fn check_end(body: &Body, what: &'static str, end: &[f64]) -> Result<(), PlanError> {
    for joint in 0..body.joint_count().max(end.len()) {
        let position = end.get(joint).copied().unwrap_or(f64::NAN);
        let limits = body.lower.get(joint).zip(body.upper.get(joint));
        // Rounded limits of a file count as reached.
        let is_within = |(low, high): (&f64, &f64)| (low - 1e-6..=high + 1e-6).contains(&position);
        if !limits.is_some_and(is_within) {
            return Err(PlanError::Configuration {
                what,
                joint,
                position,
            });
        }
    }
    Ok(())
}

fn search(
    body: &Body,
    checker: &mut Checker<'_>,
    start: &[f64],
    goal: &[f64],
    settings: &Settings,
) -> Result<(Vec<Vec<f64>>, u64), PlanError> {
    let mut trees = [Tree::new(start), Tree::new(goal)];
    // Which of the two grows towards the random configuration.
    let mut grows = 0;
    let mut sample = vec![0.0; body.joint_count()];
    let mut iterations = 0;
    while iterations < settings.max_iterations && checker.looked_at < settings.max_looks {
        iterations += 1;
        for (joint, position) in sample.iter_mut().enumerate() {
            let part = halton::value(settings.seed.wrapping_add(iterations), joint);
            *position = body.lower[joint] + part * (body.upper[joint] - body.lower[joint]);
        }
        // The smaller tree grows: it has seen less.
        if trees[grows].len() > trees[1 - grows].len() {
            grows = 1 - grows;
        }
        let Some(new) = step(&mut trees[grows], checker, &sample, settings.range) else {
            continue;
        };
        let reached = trees[grows].at(new).to_vec();
        let mut met = None;
        while let Some(node) = step(&mut trees[1 - grows], checker, &reached, settings.range) {
            if distance(trees[1 - grows].at(node), &reached) <= f64::EPSILON {
                met = Some(node);
                break;
            }
        }
        if let Some(node) = met {
            let ends = if grows == 0 { [new, node] } else { [node, new] };
            let mut path = trees[0].way(ends[0]);
            path.reverse();
            path.extend(trees[1].way(ends[1]).into_iter().skip(1));
            return Ok((path, iterations));
        }
    }
    Err(PlanError::NotFound { iterations })
}

/// Grows the tree from its nearest configuration towards `to`, by `range` at most; the new
/// one, if the way there is free.
fn step(tree: &mut Tree, checker: &mut Checker<'_>, to: &[f64], range: f64) -> Option<usize> {
    let (nearest, off) = tree.nearest(to);
    let from = tree.at(nearest);
    let at: Vec<f64> = if off <= range {
        to.to_vec()
    } else {
        let part = range / off;
        let joints = from.iter().zip(to);
        joints.map(|(from, to)| from + part * (to - from)).collect()
    };
    checker
        .is_edge_free(from, &at)
        .then(|| tree.add(&at, nearest))
}
