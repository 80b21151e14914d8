//! Which events of the matrix are pending.

use behavior::matrix::EventSet;

use super::memory::Memory;
use super::names::{Event, State};
use super::policy::Found;
use super::scene::{Bin, View};
use robocell_skills::Reached;
use robocell_skills::matrix;
use robocell_task::job::Job;
use robocell_task::time::PolicyTime;

/// All of them. Those about the grip are levels, not edges: after a restart they
/// are what they are.
pub(super) fn pending(
    state: State,
    scene: &View<'_, '_>,
    memory: &Memory,
    job: &Job,
    found: Found,
    now: PolicyTime,
) -> EventSet {
    let attached = scene.gripper.attached == 1;
    let carrying = matches!(state, State::Placing | State::Flipping | State::Detach);
    let reached = |kind| found.reached == kind;
    let lost = memory.closed && (!attached || found.grip.broken);
    let gripped = memory.closed && scene.held().is_some();
    matrix::pending(&[
        (Event::BrokenGrip, carrying && lost),
        (Event::GoalReached, reached(Reached::Goal)),
        (Event::WaypointReached, reached(Reached::Waypoint)),
        (Event::Start, may_start(state, scene, memory, job)),
        (Event::Attached, state == State::Attach && gripped),
        (
            Event::Detached,
            state == State::Detach && memory.opening() && !attached,
        ),
        (Event::Timeout, timeout(state, scene, memory, found, now)),
    ])
}

/// The start event was given, the arm is at rest, and there is a bin to take.
fn may_start(state: State, scene: &View<'_, '_>, memory: &Memory, job: &Job) -> bool {
    state == State::Standby
        && job.started
        && !job.done
        && !memory.motion.is_moving()
        && candidate(scene).is_some()
}

/// The bin to take next: the one that waits on the belt, or one that was left
/// where it does not belong.
pub(super) fn candidate(scene: &View<'_, '_>) -> Option<Bin> {
    // Without a place for it there is nothing to take.
    scene.occupied().next(scene.setup.columns.levels())?;
    scene.stray().or_else(|| scene.waiting())
}

fn timeout(
    state: State,
    scene: &View<'_, '_>,
    memory: &Memory,
    found: Found,
    now: PolicyTime,
) -> bool {
    let task = &scene.setup.task;
    let longer = |since: PolicyTime, seconds| now.since(since).seconds() > seconds;
    let suction = memory
        .acting
        .is_some_and(|since| longer(since, task.suction_timeout_s));
    match state {
        State::Standby => false,
        State::Attach if memory.closed && (found.grip.refused || suction) => {
            scene.gripper.attached == 0
        }
        _ => longer(memory.since, task.state_timeout_s),
    }
}
