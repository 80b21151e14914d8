//! One decision of the tree of an arm, and the leases of zones before it.

use std::time::Duration;

use behavior::Status;
use ipc_types::MAX_ARMS;
use robocell_task::{Job, Observation, Output, TraceEvent};

use super::{SharedBoard, StillDone, TreePolicy};
use crate::refusal::ZoneWait;
use crate::world::World;

impl TreePolicy {
    /// Renews the leases of zones whose owner is working.
    pub(super) fn watch_zones(
        &mut self,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let Self {
            setup,
            once,
            arms,
            boards,
            ..
        } = self;
        let now = observation.time().seconds();
        let mut alive = [false; ipc_types::MAX_ARMS];
        for (arm, (alive, tree)) in alive.iter_mut().zip(&*arms).enumerate() {
            let world = World::new(setup, observation, job, out, arm);
            // An arm that has done its part is not ticked again and could not release a zone
            // itself.
            *alive = world.is_alive() && !(*once && tree.status == Status::Success);
        }
        let works = |owner: &str| {
            let arm = setup.arm(owner).and_then(|arm| alive.get(arm));
            arm == Some(&true)
        };
        for SharedBoard { board, zones, .. } in boards {
            zones.watch(board, now, works, |zone, owner| {
                out.event(
                    TraceEvent::Recover,
                    format_args!("[zone] {owner} does not answer, zone '{zone}' is free"),
                );
            });
        }
    }

    pub(super) fn tick(&mut self, arm: usize, world: &mut World<'_>) {
        let Some(it) = self.arms.get_mut(arm) else {
            return;
        };
        let Some(shared) = self.boards.get_mut(it.board) else {
            return;
        };
        let now = Duration::from_millis(world.now().ticks());
        let mut status = it.tree.tick(now, &mut shared.board, world);
        world.end_refused(status == Status::Failure);
        // Decided by the observation: a tree that succeeded while its object fell has not done
        // its part.
        if status == Status::Success && was_undone(self.is_still_done.as_ref(), world) {
            status = Status::Running;
        }
        it.trace.tick(&it.tree, arm, world.out);
        let tip = it.tree.tip();
        self.shown.note(arm, tip);
        // A tree between two runs holds no zone: a failed one would block the other arm until
        // it retries.
        if status != Status::Running {
            shared.zones.leave(&mut shared.board, world.arm_name());
        }
        let name = &it.graph.name;
        // An end is told once: a tree that looks again after it succeeds again.
        let is_told = world.job.done;
        let out = &mut *world.out;
        if status == Status::Success && it.status != Status::Success && !is_told {
            out.event(TraceEvent::Done, format_args!("[done] {name}"));
            it.failed = None;
        }
        // Repeated failures at the same node are reported once: a hundred a second would fill
        // the log.
        if status == Status::Failure && it.failed != tip {
            let node = tip.and_then(|tip| it.graph.nodes.get(tip));
            let node = node.map_or("?", |node| node.name.as_str());
            out.log(format_args!(
                "[retry] {name}: '{node}' failed; the tree starts again"
            ));
            it.failed = tip;
        }
        it.status = status;
    }
}

/// Stable name of the failure of arms that wait for each other's zones.
const DEADLOCK: &str = "deadlock";

/// Fails a job whose arms wait for zones in a circle: none of them would ever continue.
pub(super) fn fail_deadlock(waits: &[Option<ZoneWait>; MAX_ARMS], world: &mut World<'_>) {
    let setup = world.setup;
    let owner = |arm: usize| {
        waits
            .get(arm)?
            .and_then(|wait| setup.arm(wait.owner.as_str()))
    };
    let is_in_circle = |first: &usize| {
        let next = |arm: &usize| owner(*arm);
        let mut others = std::iter::successors(owner(*first), next).take(MAX_ARMS);
        others.any(|arm| arm == *first)
    };
    let mut circle = (0..MAX_ARMS).filter(is_in_circle).peekable();
    if circle.peek().is_none() || world.job.failure.is_some() {
        return;
    }
    let names = circle.filter_map(|arm| {
        let wait = (*waits.get(arm)?)?;
        let name = &setup.arms.get(arm)?.name;
        Some(format!(
            "{name} waits for zone '{}' of {}",
            wait.zone, wait.owner
        ))
    });
    let why = names.collect::<Vec<_>>().join(", ");
    world.fail(DEADLOCK, format_args!("deadlock: {why}"));
}

/// Whether an arm whose tree succeeded has to work again: its work was undone, or another arm
/// needs it, before all arms had done their part.
pub(super) fn was_undone(is_still_done: Option<&StillDone>, world: &mut World<'_>) -> bool {
    if is_still_done.is_none_or(|is| is(world)) {
        return false;
    }
    let arm = world.arm_name();
    world.out.log(format_args!(
        "[retry] {arm}: there is work again; the tree starts again"
    ));
    true
}
