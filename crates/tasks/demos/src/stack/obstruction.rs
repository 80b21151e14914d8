//! Cubes in the way of another one, and free places.

use nalgebra::Vector3;
use robocell_skills::geometry::plane_distance;
use robocell_task::job::Placement;

use super::turn::Turn;

/// Two cubes of one layer whose centres are nearer than this many cube sizes leave no room for
/// the open gripper between them.
const CROWD_LAYERS: f64 = 1.6;
/// A cube nearer than this many cube sizes to a place occupies it.
const OVERLAP_LAYERS: f64 = 1.1;

/// Whether a held cube cannot go onto the stack any longer: a lower cube is not in its place,
/// or another one occupies the goal.
pub(super) fn destination_lost(turn: &Turn<'_>, cube: usize) -> bool {
    let broken = (0..cube).any(|lower| !turn.at_goal(lower));
    broken || intruder(turn, cube).is_some()
}

/// A cube that has to be moved before `cube` can be set down at its goal: one in that layer or
/// above it, too near for the open gripper, or one below it that is not part of the stack and
/// would be built over.
pub(super) fn intruder(turn: &Turn<'_>, cube: usize) -> Option<usize> {
    let layer = turn.stack.spec.layer_height_m;
    let goal = Vector3::from(turn.goal(cube).position);
    turn.others(cube).find(|other| {
        let position = turn.position(*other);
        let distance = plane_distance(position, goal);
        if position.z > goal.z - 0.6 * layer {
            distance < CROWD_LAYERS * layer
        } else {
            distance < layer && !turn.at_goal(*other)
        }
    })
}

/// The cube's own spawn, or, if that is occupied, the first one with room around it; its own if
/// none is free.
pub(super) fn free_spawn(turn: &Turn<'_>, cube: usize) -> Placement {
    let mut spawns = turn.stack.spawns.iter().copied();
    let own = spawns.clone().nth(cube).unwrap_or(turn.goal(cube));
    let nearest = |place: &Placement| {
        let others = turn.others(cube);
        let distance = |other| plane_distance(turn.position(other), place.position.into());
        others.map(distance).fold(f64::INFINITY, f64::min)
    };
    let layer = turn.stack.spec.layer_height_m;
    // At the start all cubes are at their spawns, however close to each other.
    if nearest(&own) > OVERLAP_LAYERS * layer {
        return own;
    }
    let free = spawns.find(|spawn| nearest(spawn) > CROWD_LAYERS * layer);
    free.unwrap_or(own)
}
