//! Asking the conveyor for bins, and letting it run.

use cell_model::random::Random;
use robocell_task::TraceEvent;

use super::memory::SupplyMemory;
use super::scene::View;
use super::setup::BinStackSetup;
use crate::failure::Failure;
use robocell_task::job::Job;
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

/// Steps of the source in a second.
const STEPS_PER_SECOND: u64 = 60;
/// The first bin is asked for this long after the start.
const FIRST: PolicyTime = PolicyTime::from_ticks(200);
/// A bin that was asked for and did not come is asked for again after this.
const ASK_AGAIN: PolicyTime = PolicyTime::from_ticks(5_000);
/// With nothing to pick and nothing to come for this long, what is not in place is
/// given up.
const LOST_AFTER: PolicyTime = PolicyTime::from_ticks(20_000);

impl SupplyMemory {
    /// A bin was picked from the belt: the next one comes after a while that the
    /// seed decides.
    pub(super) fn picked(&mut self, setup: &BinStackSetup, now: PolicyTime) {
        let [least, most] = setup.task.next_bin_steps.map(u64::from);
        self.picks += 1;
        let mut random = Random::new(setup.seed ^ (self.picks << 20));
        let steps = least + random.bits() % (most.saturating_sub(least) + 1);
        let delay = steps * 1000 / STEPS_PER_SECOND;
        self.next_at = Some(PolicyTime::from_ticks(now.ticks() + delay));
    }
}

/// Runs the belt until a bin is at its end.
pub(super) fn run_belt(scene: &View<'_, '_>, job: &mut Job) {
    job.io.conveyor_running = job.started && !scene.belt_end_taken();
}

/// Outputs to the conveyor in this decision.
pub(super) fn update(
    scene: &View<'_, '_>,
    memory: &mut SupplyMemory,
    job: &mut Job,
    out: &mut Output,
    now: PolicyTime,
) {
    run_belt(scene, job);
    if !job.started || job.done {
        return;
    }
    let in_cell = scene.bins().count();
    let on_belt = scene.bins().filter(|bin| scene.on_belt(bin)).count();
    // Not at once: physics has to hear this task once before it hears a request.
    if memory.asked_at.is_none() && memory.next_at.is_none() {
        memory.next_at = Some(PolicyTime::from_ticks(now.ticks() + FIRST.ticks()));
    }
    let due = memory.next_at.is_some_and(|at| now >= at);
    let waited = memory.asked_at.is_some_and(|at| now.since(at) > ASK_AGAIN);
    let nothing_comes = memory.next_at.is_none() && on_belt == 0 && waited;
    if in_cell < scene.setup.wanted && (due || nothing_comes) {
        job.io.add_bin += 1;
        memory.asked_at = Some(now);
        memory.next_at = None;
    }
    let idle = in_cell >= scene.setup.wanted
        && on_belt == 0
        && job.held.is_none()
        && scene.stray().is_none();
    note_lost(idle, scene, memory, job, out, now);
}

/// All bins came, not all are in place, and there is none to pick: the first of
/// those names the reason.
fn note_lost(
    idle: bool,
    scene: &View<'_, '_>,
    memory: &mut SupplyMemory,
    job: &mut Job,
    out: &mut Output,
    now: PolicyTime,
) {
    if !idle {
        memory.missing_since = None;
        return;
    }
    let since = *memory.missing_since.get_or_insert(now);
    if now.since(since) <= LOST_AFTER {
        return;
    }
    memory.missing_since = None;
    let left = scene.bins().find(|bin| scene.slot(bin).is_none());
    let name = left.map_or("a bin", |bin| scene.setup.name(bin.object));
    let (failure, why) = match left {
        Some(bin) if !bin.flat() => (Failure::BinCannotBeGripped, "leans"),
        Some(_) => (Failure::BinOutOfReach, "cannot be reached"),
        None => (Failure::BinLost, "is missing"),
    };
    out.event(
        TraceEvent::Fault,
        format_args!("[failed] {name} {why}, and no other is left"),
    );
    job.fail(failure.reason());
}
