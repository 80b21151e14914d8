//! Which events are pending in a decision.

use behavior::matrix::EventSet;

use super::memory::Memory;
use super::names::{Event, State};
use super::scene::Scene;
use crate::job::Job;
use crate::time::PolicyTime;
use crate::ur10::{GripChange, Reached};

/// Every so often TIMEOUT is pending, as in the source (s): nothing handles it
/// there or here.
const TIMEOUT: PolicyTime = PolicyTime::from_ticks(500);

/// What the records compared with the observation say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) grip: GripChange,
    pub(super) reached: Reached,
}

/// The pending events, on top of what `memory` keeps.
pub(super) fn pending(
    state: State,
    scene: &Scene<'_, '_>,
    memory: &Memory,
    job: &Job,
    found: Found,
    now: PolicyTime,
) -> EventSet {
    let in_state = now.since(memory.since);
    let late = in_state > scene.setup.times.state;
    let events = [
        (Event::Detached, found.grip.detached),
        (Event::GoalReached, found.reached == Reached::Goal),
        (Event::WaypointReached, found.reached == Reached::Waypoint),
        (Event::Start, start(state, memory, job)),
        (Event::Attached, memory.attached),
        (
            Event::Stop,
            late && matches!(state, State::Picking | State::Attach),
        ),
        (
            Event::Timeout,
            in_state.ticks() > 0 && in_state.ticks().is_multiple_of(TIMEOUT.ticks()),
        ),
    ];
    events
        .into_iter()
        .filter(|(_, is_pending)| *is_pending)
        .fold(EventSet::EMPTY, |set, (event, _)| set.with(event.id()))
}

/// The start event is latched: it is pending until the arm is on its way.
fn start(state: State, memory: &Memory, job: &Job) -> bool {
    job.started && state == State::Standby && !memory.motion.is_moving() && !memory.grip.attached()
}
