//! Which events are pending in a decision.

use behavior::matrix::EventSet;

use super::memory::Memory;
use super::names::{Event, State};
use super::policy::Found;
use super::scene::View;
use robocell_skills::Reached;
use robocell_skills::matrix;
use robocell_task::job::Job;
use robocell_task::time::PolicyTime;

/// Every so often TIMEOUT is pending, as in the source (s): nothing handles it
/// there or here.
const TIMEOUT: PolicyTime = PolicyTime::from_ticks(500);

/// The pending events, on top of what `memory` keeps.
pub(super) fn pending(
    state: State,
    scene: &View<'_, '_>,
    memory: &Memory,
    job: &Job,
    found: Found,
    now: PolicyTime,
) -> EventSet {
    let in_state = now.since(memory.since);
    let late = in_state > scene.setup.times.state;
    let picks = matches!(state, State::Picking | State::Attach);
    let reached = |kind| found.reached == kind;
    matrix::pending(&[
        (Event::Detached, found.grip.detached),
        (Event::GoalReached, reached(Reached::Goal)),
        (Event::WaypointReached, reached(Reached::Waypoint)),
        (Event::Start, start(state, memory, job)),
        (Event::Attached, memory.attached),
        (Event::Stop, late && picks),
        (
            Event::Timeout,
            in_state.ticks() > 0 && in_state.ticks().is_multiple_of(TIMEOUT.ticks()),
        ),
    ])
}

/// The start event is latched: it is pending until the arm is on its way.
fn start(state: State, memory: &Memory, job: &Job) -> bool {
    job.started && state == State::Standby && !memory.motion.is_moving() && !memory.grip.attached()
}
