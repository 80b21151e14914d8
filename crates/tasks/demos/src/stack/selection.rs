//! The choice of the next cube, and of its destination.

use ipc_types::GripperGoal;
use robocell_skills::geometry::plane_distance;
use robocell_task::TraceEvent;

use super::obstruction::{free_spawn, intruder};
use super::transfer::Transfer;
use super::turn::Turn;
use crate::failure::Failure;

/// Whether all cubes are at their goals. The result is stored in the job, and logged when it
/// becomes true.
pub fn all_stacked(turn: &mut Turn<'_>) -> bool {
    let all = turn.cubes().all(|cube| turn.at_goal(cube));
    if all && !turn.world.job.done {
        let line = format_args!("[decide] -> all stacked");
        turn.world.out.event(TraceEvent::Done, line);
    }
    turn.world.job.done = all;
    all
}

impl Transfer {
    /// The next transfer, with its first command; `None` if nothing can be moved now. `verb`
    /// starts the log line.
    pub fn select(verb: &str, turn: &mut Turn<'_>) -> Option<Self> {
        let job_failed = turn.world.job.failure.is_some();
        let next = (!job_failed).then(|| select(verb, turn));
        let Some(mut transfer) = next.flatten() else {
            turn.hold(GripperGoal::Keep);
            return None;
        };
        transfer.aim(turn);
        transfer.drive(turn);
        Some(transfer)
    }
}

/// The transfer of the first cube in the order that is not at its goal. A cube on top of it, or
/// at its goal, is moved away first, since neither picking nor placing could succeed; a support
/// that is too far off to carry the next cube is set again. `None` if nothing can be moved now,
/// with the reason stored in the job. `verb` starts the log line.
pub fn select(verb: &str, turn: &mut Turn<'_>) -> Option<Transfer> {
    all_stacked(turn);
    // First of all: with a cube on the floor the stack cannot be completed.
    if let Some(cube) = turn.cubes().find(|cube| turn.fallen(*cube)) {
        let name = turn.name(cube);
        let reason = Failure::CubeLost.reason();
        turn.world
            .fail(reason, format_args!("{name} fell off the table"));
        return None;
    }
    let first = turn.cubes().find(|cube| !turn.at_goal(*cube));
    let next = first.map(|first| {
        let wanted = unseated_support(turn, first).unwrap_or(first);
        clear_the_way(turn, wanted)
    });
    // Out of reach is a wait before it is a failure: an operator may push the cube back.
    if let Some(next) = next.filter(|next| !turn.reachable(next.cube)) {
        let (object, reason) = (turn.object(next.cube), Failure::CubeOutOfReach.reason());
        turn.world.wait_for_reach(object, reason);
        return None;
    }
    turn.world.note_in_reach();
    if let Some(next) = next {
        let name = turn.name(next.cube);
        let what = if next.aborted { "clear" } else { "stack" };
        turn.world.job.counters.recoveries += u32::from(next.aborted);
        let line = format_args!("[{verb}] -> {what} {name}");
        turn.world.out.log(line);
    }
    next
}

/// The cube below `first`, if it is too far off to carry it and was not set again too often.
fn unseated_support(turn: &Turn<'_>, first: usize) -> Option<usize> {
    let support = first.checked_sub(1)?;
    let attempts = turn.world.attempts(turn.object(support)).place;
    (!turn.seated(support) && attempts < turn.stack.spec.max_attempts).then_some(support)
}

/// `wanted` to its goal, or first a cube that is in the way.
fn clear_the_way(turn: &Turn<'_>, wanted: usize) -> Transfer {
    let away = |cube| Transfer::new(turn, cube, free_spawn(turn, cube), true);
    let mut next = match intruder(turn, wanted) {
        Some(cube) if on_top_of(turn, wanted).is_none() => away(cube),
        _ => Transfer::new(turn, wanted, turn.goal(wanted), false),
    };
    // A pile is taken down from the top; the loop ends, because a pile has at most all cubes.
    for _ in turn.cubes() {
        match on_top_of(turn, next.cube) {
            Some(cube) => next = away(cube),
            None => break,
        }
    }
    next
}

/// The cube on top of `cube`.
fn on_top_of(turn: &Turn<'_>, cube: usize) -> Option<usize> {
    let layer = turn.stack.spec.layer_height_m;
    let base = turn.position(cube);
    turn.others(cube).find(|other| {
        let position = turn.position(*other);
        let rise = position.z - base.z;
        rise > 0.5 * layer && rise < 1.5 * layer && plane_distance(position, base) < 0.9 * layer
    })
}
