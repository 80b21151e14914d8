//! Which events of the matrix are pending.

use behavior::matrix::EventSet;

use super::memory::Memory;
use super::names::{EVENTS, State};
use super::scene::Scene;
use crate::job::Job;
use crate::time::PolicyTime;
use crate::ur10::{GripChange, Reached};

/// What the decision found out before it asks the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) reached: Reached,
    pub(super) grip: GripChange,
}

/// All of them. Those about the grip are levels, not edges: after a restart they
/// are what they are.
pub(super) fn pending(
    state: State,
    scene: &Scene<'_, '_>,
    memory: &Memory,
    job: &Job,
    found: Found,
    now: PolicyTime,
) -> EventSet {
    let attached = scene.gripper.attached == 1;
    let carrying = matches!(state, State::Placing | State::Flipping | State::Detach);
    let events = [
        (
            "BROKENGRIP",
            carrying && memory.closed && (!attached || found.grip.broken),
        ),
        ("GOAL_REACHED", found.reached == Reached::Goal),
        ("WAYPOINT_REACHED", found.reached == Reached::Waypoint),
        ("START", may_start(state, scene, memory, job)),
        (
            "ATTACHED",
            state == State::Attach && memory.closed && scene.held().is_some(),
        ),
        (
            "DETACHED",
            state == State::Detach && memory.opening() && !attached,
        ),
        ("TIMEOUT", timeout(state, scene, memory, found, now)),
    ];
    events
        .into_iter()
        .filter(|(_, holds)| *holds)
        .fold(EventSet::EMPTY, |set, (name, _)| with(set, name))
}

/// The start event was given, the arm is at rest, and there is a bin to take.
fn may_start(state: State, scene: &Scene<'_, '_>, memory: &Memory, job: &Job) -> bool {
    state == State::Standby
        && job.started
        && !job.done
        && !memory.motion.is_moving()
        && candidate(scene).is_some()
}

/// The bin to take next: the one that waits on the belt, or one that was left
/// where it does not belong.
pub(super) fn candidate(scene: &Scene<'_, '_>) -> Option<super::scene::Bin> {
    let places = scene.occupied().next(scene.setup.columns.levels());
    places?;
    scene.stray().or_else(|| scene.waiting())
}

fn timeout(
    state: State,
    scene: &Scene<'_, '_>,
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

fn with(set: EventSet, name: &str) -> EventSet {
    let place = EVENTS.iter().position(|event| *event == name);
    let id = place.and_then(|place| u16::try_from(place).ok());
    id.map_or(set, |id| set.with(behavior::matrix::EventId(id)))
}
