//! Which cube is moved next, and where to.

use super::geometry::plane_distance;
use super::recovery::{
    CROWD_LAYERS, at_goal, fallen, free_spawn, reachable, seated, stack_below_broken,
};
use super::scene::View;
use super::setup::StackSetup;
use crate::failure::Failure;
use robocell_task::TraceEvent;
use robocell_task::job::{Job, Placement};
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// A cube out of reach is waited for this long; somebody may bring it back.
const REACH_PATIENCE: PolicyTime = PolicyTime::from_ticks(10_000);

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Selection {
    /// Every cube is at its goal.
    AllPlaced,
    /// Move this cube.
    Move(Assignment),
    /// The next cube is out of reach.
    OutOfReach(usize),
    /// This cube is off the table.
    Fallen(usize),
}

/// A cube to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assignment {
    /// Its place in the order.
    pub cube: usize,
    /// Where it goes.
    pub destination: Placement,
    /// It is only moved out of the way.
    pub clears: bool,
}

/// The first cube in the order that is not at its goal. Finer than the demos:
/// a cube that lies on it, or where it belongs, is put away first, since
/// neither picking nor placing could succeed; and a support that stands too far
/// off to carry the next cube is set again.
pub fn select(setup: &StackSetup, scene: &View, job: &Job) -> Selection {
    let count = setup.cubes.len();
    if let Some(cube) = (0..count).find(|c| fallen(scene, *c)) {
        return Selection::Fallen(cube);
    }
    let Some(first) = (0..count).find(|c| !at_goal(setup, scene, *c)) else {
        return Selection::AllPlaced;
    };
    let wanted = unseated_support(setup, scene, job, first).unwrap_or(first);
    let assignment = clear_the_way(setup, scene, wanted);
    match assignment.cube {
        cube if reachable(setup, scene, cube) => Selection::Move(assignment),
        cube => Selection::OutOfReach(cube),
    }
}

/// Whether a held cube cannot go onto the stack any more: a lower cube is not
/// where it belongs, or another one got to its own place.
pub fn destination_lost(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    let taken = |goal| intruder(setup, scene, cube, goal).is_some();
    stack_below_broken(setup, scene, cube) || setup.cube(cube).is_some_and(|c| taken(c.goal))
}

/// Selects, and notes what came of it: the log line, which begins with `verb`, the wait for a cube out of
/// reach, the end of the job. `None`: nothing to move now.
pub fn decide(
    setup: &StackSetup,
    scene: &View,
    now: PolicyTime,
    verb: &str,
    job: &mut Job,
    out: &mut Output,
) -> Option<Assignment> {
    let selection = select(setup, scene, job);
    if !matches!(selection, Selection::OutOfReach(_)) {
        job.unreachable_since = None;
    }
    note_all_placed(selection == Selection::AllPlaced, job, out);
    match selection {
        Selection::AllPlaced => {}
        Selection::Move(assignment) => return Some(announce(setup, assignment, verb, job, out)),
        Selection::OutOfReach(cube) => wait(setup, cube, now, job, out),
        Selection::Fallen(cube) => {
            out.event(
                TraceEvent::Fault,
                format_args!("[failed] {} fell off the table", setup.name(cube)),
            );
            job.fail(Failure::CubeLost.reason());
        }
    }
    None
}

/// Notes whether every cube is at its goal, and says so when it has just become
/// true.
pub fn note_all_placed(all: bool, job: &mut Job, out: &mut Output) {
    if all && !job.done {
        out.event(TraceEvent::Done, format_args!("[decide] -> all stacked"));
    }
    job.done = all;
}

fn announce(
    setup: &StackSetup,
    assignment: Assignment,
    verb: &str,
    job: &mut Job,
    out: &mut Output,
) -> Assignment {
    let name = setup.name(assignment.cube);
    if assignment.clears {
        job.counters.recoveries += 1;
        out.log(format_args!("[{verb}] -> clear {name}"));
    } else {
        out.log(format_args!("[{verb}] -> stack {name}"));
    }
    assignment
}

fn wait(setup: &StackSetup, cube: usize, now: PolicyTime, job: &mut Job, out: &mut Output) {
    let name = setup.name(cube);
    match job.unreachable_since {
        None => {
            out.log(format_args!("[wait] {name} is out of reach"));
            job.unreachable_since = Some(now);
        }
        Some(since) if now.since(since) >= REACH_PATIENCE => {
            out.event(
                TraceEvent::Fault,
                format_args!("[failed] {name} stayed out of reach"),
            );
            job.fail(Failure::CubeOutOfReach.reason());
        }
        Some(_) => {}
    }
}

/// The cube below `first`, if it stands too far off to carry it and setting it
/// again was not tried too often.
fn unseated_support(setup: &StackSetup, scene: &View, job: &Job, first: usize) -> Option<usize> {
    let support = first.checked_sub(1)?;
    let attempts = setup.cube(support).map(|c| job.attempts(c.object).place)?;
    (!seated(setup, scene, support) && attempts < setup.spec.max_attempts).then_some(support)
}

/// `wanted` to its goal, or first whatever is in the way of that.
fn clear_the_way(setup: &StackSetup, scene: &View, wanted: usize) -> Assignment {
    let goal = setup.cube(wanted).map(|c| c.goal);
    let away = |cube| Assignment {
        cube,
        destination: free_spawn(setup, scene, cube),
        clears: true,
    };
    let mut next = match goal {
        Some(destination) => Assignment {
            cube: wanted,
            destination,
            clears: false,
        },
        None => away(wanted),
    };
    if let Some(cube) = on_top_of(setup, scene, wanted) {
        next = away(cube);
    } else if let Some(cube) = goal.and_then(|goal| intruder(setup, scene, wanted, goal)) {
        next = away(cube);
    }
    // A pile is taken down from the top; a pile has no more cubes than there are.
    for _ in 0..setup.cubes.len() {
        match on_top_of(setup, scene, next.cube) {
            Some(cube) => next = away(cube),
            None => break,
        }
    }
    next
}

/// The cube that lies on `cube`.
fn on_top_of(setup: &StackSetup, scene: &View, cube: usize) -> Option<usize> {
    let layer = setup.spec.layer_height_m;
    let base = scene.cube(cube).position;
    (0..setup.cubes.len()).find(|other| {
        let position = scene.cube(*other).position;
        let rise = position.z - base.z;
        *other != cube
            && rise > 0.5 * layer
            && rise < 1.5 * layer
            && plane_distance(position, base) < 0.9 * layer
    })
}

/// A cube that has to go before `cube` can be set down at `goal`: one in that
/// layer or above it, too near for the open gripper, or one below it that is no
/// part of the stack and would be built over.
fn intruder(setup: &StackSetup, scene: &View, cube: usize, goal: Placement) -> Option<usize> {
    let layer = setup.spec.layer_height_m;
    (0..setup.cubes.len()).find(|other| {
        let position = scene.cube(*other).position;
        let distance = plane_distance(position, goal.position.into());
        let beside = position.z > goal.position[2] - 0.6 * layer;
        let in_the_way = if beside {
            distance < CROWD_LAYERS * layer
        } else {
            distance < layer && !at_goal(setup, scene, *other)
        };
        *other != cube && in_the_way
    })
}
