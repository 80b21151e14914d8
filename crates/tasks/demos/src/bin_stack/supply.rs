//! Requests for bins, and the motion of the belt.

use cell_model::random::Random;
use robocell_task::{Job, PolicyTime};

use super::carry::no_slot;
use super::job::{BinStack, SupplyMemory, Turn};
use super::numbers::STEPS_PER_SECOND;
use super::scene::View;
use crate::failure::Failure;

impl SupplyMemory {
    /// A bin was picked from the belt: the next one follows after a delay drawn from the seed.
    pub(super) fn picked(&mut self, of: &BinStack, now: PolicyTime) {
        let [least, most] = of.task.next_bin_steps.map(u64::from);
        self.picks += 1;
        // The generator is made from seed and count, not kept: a restored task draws the same
        // delay.
        let mut random = Random::new(of.seed ^ (self.picks << 20));
        let steps = least + random.bits() % (most.saturating_sub(least) + 1);
        let delay = steps * 1000 / STEPS_PER_SECOND;
        self.next_at = Some(PolicyTime::from_ticks(now.ticks() + delay));
    }
}

/// Runs the belt until a bin is at its end.
pub(super) fn run_belt(view: View<'_>, job: &mut Job) {
    // Stopped while a held bin is over the end, too: the next one would be driven into it.
    job.io.conveyor_running = job.started && !view.belt_end_taken();
}

/// Sets the requests to the conveyor of this decision.
pub(super) fn update(turn: &mut Turn<'_>) {
    let (view, now, own) = (View::of(turn), turn.now, turn.own);
    let job = &mut *turn.world.job;
    run_belt(view, job);
    // The belt is run even before the start, above; bins are requested only afterwards.
    if !job.started || job.done {
        return;
    }
    let memory = &mut turn.memory.supply;
    let all_came = view.bins().count() >= view.of.wanted;
    let on_belt = view.bins().any(|bin| view.on_belt(&bin));
    // Not at once: physics ignores the first counter of a task that it sees, since an older
    // task may have counted before.
    if memory.asked_at.is_none() && memory.next_at.is_none() {
        memory.next_at = Some(PolicyTime::from_ticks(now.ticks() + own.first_bin.ticks()));
    }
    let due = memory.next_at.is_some_and(|at| now >= at);
    let waited = |at| now.since(at) > own.ask_again;
    // A request can be lost (the belt was full, physics was restarted). It is repeated only
    // while the belt is empty, so that no two bins follow each other.
    let nothing_comes = memory.next_at.is_none() && !on_belt && memory.asked_at.is_some_and(waited);
    if !all_came && (due || nothing_comes) {
        job.io.add_bin += 1;
        memory.asked_at = Some(now);
        memory.next_at = None;
    }
    // A bin that waits at the end of the belt holds up those that are still to come.
    let nothing_comes = view.waiting().is_some() || all_came && !on_belt;
    let idle = nothing_comes && job.held.is_none() && view.candidate().is_none();
    note_lost(idle, turn);
}

/// Fails the job if not all bins are in place, none is to come and none can be picked; the reason
/// is that of one that leans, else of the first one.
fn note_lost(idle: bool, turn: &mut Turn<'_>) {
    let since = &mut turn.memory.supply.missing_since;
    if !idle {
        *since = None;
        return;
    }
    if turn.now.since(*since.get_or_insert(turn.now)) <= turn.own.lost_after {
        return;
    }
    *since = None;
    let view = View::of(turn);
    let left = || view.bins().filter(|bin| view.slot(bin).is_none());
    let left = left().find(|bin| !bin.can_be_gripped()).or(left().next());
    let name = left.map_or("a bin", |bin| turn.name(bin.object));
    let (failure, why) = match left.map(|bin| (bin, view.next_slot(&bin))) {
        Some((bin, _)) if !bin.can_be_gripped() => {
            (Failure::BinCannotBeGripped, "leans".to_owned())
        }
        Some((_, Err(blocked))) => (Failure::PlaceTaken, no_slot(turn, blocked)),
        Some(_) => (Failure::BinOutOfReach, "cannot be reached".to_owned()),
        None => (Failure::BinLost, "is missing".to_owned()),
    };
    let why = format_args!("{name}: {why}, and no other is left");
    turn.world.fail(failure.reason(), why);
}
