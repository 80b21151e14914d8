//! `RRT`-Connect: two trees that grow towards each other.
//!
//! Both ends are checked first, then the straight line between them, and only then the trees
//! grow. The steps have an order that a change must keep: a caller relies on zero iterations
//! as the sign that no detour was needed, and on the kind of the error as the reason that it
//! shows. Random configurations are those of a Halton sequence that the seed shifts, so that a
//! request has one answer, and another seed another one.

use thiserror::Error;

use crate::body::Body;
use crate::check::{Checker, distance};
use crate::halton;
use crate::scene::{Scene, single};
use crate::shortcut::{length, shorten};
use crate::tree::Tree;

/// Settings of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Selects the random configurations.
    pub seed: u64,
    /// Largest number of random configurations.
    pub max_iterations: u64,
    /// Largest number of comparisons of a solid with sixteen configurations of an edge: bounds
    /// the cost of a search for any number of solids.
    pub max_looks: u64,
    /// Largest length of an edge (rad, m).
    pub range: f64,
    /// Configurations that are checked for each rad (m) of an edge.
    pub resolution: f64,
    /// Distance of the spheres from the scene (m), as far as start and goal keep it: the
    /// motion between two checked configurations is within it.
    pub padding: f64,
    /// Number of attempts to cut a corner.
    pub shortcuts: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            seed: 0,
            max_iterations: 100_000,
            max_looks: 100_000_000,
            range: 1.5,
            // With 96 a joint turns by 10 mrad between two checked configurations; the padding
            // covers the motion in between (ADR 0019).
            resolution: 96.0,
            padding: 0.002,
            shortcuts: 60,
        }
    }
}

/// A free path.
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
    /// The configuration (rad or m) at a part of the length, 0 to 1; a part outside of this
    /// range gives the start or the end. Empty for a path without waypoints.
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

/// Reason why no path was found.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PlanError {
    /// Start or goal has another number of joints, or a position that is not finite or
    /// outside of the limits of its joint.
    #[error(
        "the {what} is not a configuration of the arm: joint {joint} is at {position}; a finite position within the limits of each joint is needed"
    )]
    Configuration {
        /// `start` or `goal`.
        what: &'static str,
        /// Index of the joint.
        joint: usize,
        /// Its position (rad or m); NaN if it is missing.
        position: f64,
    },
    /// The arm already touches the scene, or itself.
    #[error(
        "the {what} is in collision with the scene or with the arm itself; move the arm or the obstacle"
    )]
    InCollision {
        /// `start` or `goal`.
        what: &'static str,
    },
    /// The pose is not a finite position with a unit orientation.
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
    /// No path was found within the limits of the search; there may be none.
    #[error("no path was found in {iterations} iterations; allow more, or choose another goal")]
    NotFound {
        /// Random configurations that were tried.
        iterations: u64,
    },
}

/// A path of `body` in `scene` from `start` to `goal` (rad or m).
///
/// # Errors
/// [`PlanError`] if an end is invalid or in collision, or no path was found.
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
        // Ends are checked without padding: an arm may start at rest beside an obstacle.
        if !checker.is_free(end) {
            return Err(PlanError::InCollision { what });
        }
    }
    checker.padding = padding(&mut checker, &[start, goal], settings.padding);
    // The straight line first: 0 iterations also tell the caller that no path was needed.
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

/// The padding, or the largest part of it that both ends keep.
fn padding(checker: &mut Checker<'_>, ends: &[&[f64]; 2], wanted: f64) -> f32 {
    // Without this an arm that starts near an obstacle would never get away from it.
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
        // Limits of a file are rounded; a position at one of them is within it.
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
    // Index of the tree that grows towards the random configuration.
    let mut grows = 0;
    let mut sample = vec![0.0; body.joint_count()];
    let mut iterations = 0;
    while iterations < settings.max_iterations && checker.looked_at < settings.max_looks {
        iterations += 1;
        for (joint, position) in sample.iter_mut().enumerate() {
            let part = halton::value(settings.seed.wrapping_add(iterations), joint);
            *position = body.lower[joint] + part * (body.upper[joint] - body.lower[joint]);
        }
        // The smaller tree grows, so that both explore: in a narrow place one would stay
        // small.
        if trees[grows].len() > trees[1 - grows].len() {
            grows = 1 - grows;
        }
        let Some(new) = step(&mut trees[grows], checker, &sample, settings.range) else {
            continue;
        };
        let reached = trees[grows].at(new).to_vec();
        let mut met = None;
        // The other tree is extended until it is blocked: this is the "connect" of the method.
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

/// Grows the tree from its nearest configuration towards `to`, by at most `range`; returns the
/// new configuration if the edge is free.
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
