//! What can go wrong with a cube, and what is noted when it does.

use super::geometry::plane_distance;
use super::phase::Phase;
use super::scene::View;
use super::setup::StackSetup;
use crate::failure::Failure;
use nalgebra::{Vector2, Vector3};
use robocell_task::TraceEvent;
use robocell_task::job::{Job, Placement};
use robocell_task::output::Output;

/// A cube below this height is off the table (m); the table's top is at 0.
const FALLEN_BELOW_M: f64 = -0.05;

/// Share of a layer by which a cube may stand off and still carry the next: at
/// half a cube the next one topples.
const SEAT_SHARE: f64 = 0.4;

/// Whether a cube is at its goal: strictly nearer than the tolerance, and in its
/// own layer. The demos look at the distance alone; their 0.06 m is more than a
/// layer, so they take two cubes in the wrong order for right.
pub fn at_goal(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    let Some(spec) = setup.cube(cube) else {
        return true;
    };
    let offset = scene.cube(cube).position - Vector3::from(spec.goal.position);
    offset.norm() < setup.spec.goal_tolerance_m && offset.z.abs() < setup.spec.layer_height_m / 2.0
}

/// Whether a cube is at its goal well enough to carry the next one.
pub fn seated(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    let Some(spec) = setup.cube(cube) else {
        return true;
    };
    let offset = plane_distance(scene.cube(cube).position, spec.goal.position.into());
    at_goal(setup, scene, cube) && offset < SEAT_SHARE * setup.spec.layer_height_m
}

/// Whether a cube below `cube` in the order is not where it belongs.
pub fn stack_below_broken(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    (0..cube).any(|lower| !at_goal(setup, scene, lower))
}

/// Whether a cube that ought to be in the hand is not: strictly further than
/// the drop distance from the measured TCP. The demos measure to a finger link;
/// the TCP lies between the fingers.
pub fn dropped(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    scene.distance_to_tcp(cube) > setup.spec.drop_distance_m
}

/// Whether a cube left `reference` (m, in the plane) by more than the tolerance.
pub fn moved(setup: &StackSetup, scene: &View, cube: usize, reference: Vector2<f64>) -> bool {
    (scene.cube(cube).position.xy() - reference).norm() > setup.spec.move_tolerance_m
}

/// Whether a cube is off the table.
pub fn fallen(scene: &View, cube: usize) -> bool {
    scene.cube(cube).position.z < FALLEN_BELOW_M
}

/// Whether the arm reaches a cube.
pub fn reachable(setup: &StackSetup, scene: &View, cube: usize) -> bool {
    (scene.cube(cube).position.xy() - setup.base).norm() <= setup.spec.reach_m
}

/// Notes that the held cube was lost.
pub fn note_drop(setup: &StackSetup, cube: usize, job: &mut Job, out: &mut Output) {
    job.counters.drops += 1;
    forget_held(job);
    out.event(
        TraceEvent::Drop,
        format_args!(
            "[drop] {} left the gripper, deciding again",
            setup.name(cube)
        ),
    );
    note_failed_pick(setup, cube, job);
}

/// Notes that a cube moved while it was picked up. The hand that pushes a cube
/// away on the way down would do so for ever, so that counts as a failed
/// pick-up; an operator who drags it may go on as he likes.
pub fn note_resync(
    setup: &StackSetup,
    scene: &View,
    cube: usize,
    phase: Phase,
    job: &mut Job,
    out: &mut Output,
) {
    job.counters.resyncs += 1;
    out.event(
        TraceEvent::Resync,
        format_args!("[resync] {} moved, picking it up anew", setup.name(cube)),
    );
    if phase == Phase::Approach && !scene.cube(cube).dragged {
        note_failed_pick(setup, cube, job);
    }
}

/// Turns a transfer back: the held cube goes to its own spawn, or to another
/// free one where something stands on its own.
pub fn note_abort(
    setup: &StackSetup,
    scene: &View,
    cube: usize,
    job: &mut Job,
    out: &mut Output,
) -> Placement {
    job.counters.aborts += 1;
    out.event(
        TraceEvent::Abort,
        format_args!(
            "[abort] the stack is broken, {} goes back to its spawn",
            setup.name(cube)
        ),
    );
    free_spawn(setup, scene, cube)
}

/// Notes how a set-down ended: a cube that does not stay where it was put is
/// tried again, but not for ever.
pub fn note_placed(setup: &StackSetup, scene: &View, cube: usize, job: &mut Job) {
    let seated = seated(setup, scene, cube);
    let at_goal = at_goal(setup, scene, cube);
    let Some(attempts) = setup.cube(cube).and_then(|c| job.attempts_mut(c.object)) else {
        return;
    };
    attempts.place = if seated { 0 } else { attempts.place + 1 };
    if !at_goal && attempts.place >= setup.spec.max_attempts {
        job.fail(Failure::CubeCannotBePlaced.reason());
    }
}

/// Notes that a cube came to its destination in the gripper.
pub fn note_carried(setup: &StackSetup, cube: usize, job: &mut Job) {
    if let Some(attempts) = setup.cube(cube).and_then(|c| job.attempts_mut(c.object)) {
        attempts.pick = 0;
    }
}

/// Notes that the gripper stays shut.
pub fn note_blocked(setup: &StackSetup, cube: usize, job: &mut Job, out: &mut Output) {
    out.event(
        TraceEvent::Fault,
        format_args!("[failed] the gripper does not open at {}", setup.name(cube)),
    );
    job.fail(Failure::GripperBlocked.reason());
}

/// Nothing is in the hand any more.
pub fn forget_held(job: &mut Job) {
    job.held = None;
    job.destination = None;
    job.aborted = false;
}

fn note_failed_pick(setup: &StackSetup, cube: usize, job: &mut Job) {
    let Some(attempts) = setup.cube(cube).and_then(|c| job.attempts_mut(c.object)) else {
        return;
    };
    attempts.pick += 1;
    if attempts.pick >= setup.spec.max_attempts {
        job.fail(Failure::CubeCannotBeGripped.reason());
    }
}

/// The cube's own spawn, or the first one with room around it where something
/// stands on its own; its own if there is none.
pub fn free_spawn(setup: &StackSetup, scene: &View, cube: usize) -> Placement {
    let own = setup.cube(cube).map_or(NOWHERE, |c| c.spawn);
    let nearest = |place: &Placement| {
        let others = (0..setup.cubes.len()).filter(|other| *other != cube);
        let distance = |other| plane_distance(scene.cube(other).position, place.position.into());
        others.map(distance).fold(f64::INFINITY, f64::min)
    };
    // At the start all cubes stood at their spawns, however close.
    if nearest(&own) > OVERLAP_LAYERS * setup.spec.layer_height_m {
        return own;
    }
    let room = CROWD_LAYERS * setup.spec.layer_height_m;
    let mut spawns = setup.cubes.iter().map(|c| c.spawn);
    spawns.find(|spawn| nearest(spawn) > room).unwrap_or(own)
}

/// For a cube that is not in the order, which nobody asks for.
const NOWHERE: Placement = Placement {
    position: [0.0; 3],
    yaw: 0.0,
};

/// Two cubes of one layer with centres nearer than this many cube sizes leave
/// no room for the open gripper between them.
pub const CROWD_LAYERS: f64 = 1.6;
/// Nearer than this they stand in each other.
const OVERLAP_LAYERS: f64 = 1.1;
