//! What to do with a bin, and which substep comes next.

use super::geometry::{Lie, lie};
use super::memory::{Work, WorkKind};
use super::policy::Palletizer;
use super::progress::{Judge, Progress};
use super::steps::{Sequence, Step};
use super::table::{State, Trigger};
use super::tick::Tick;
use crate::failure::Failure;
use robocell_skills::KeptPose;
use robocell_task::TraceEvent;
use robocell_task::job::Job;
use robocell_task::output::Output;

impl Palletizer {
    pub(super) fn advance(&mut self, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        if self.states.state() == State::Done {
            return;
        }
        match self.memory.work {
            Some(work) if self.states.state() != State::Idle => self.go_on(work, tick, job, out),
            _ => self.choose(tick, job, out),
        }
    }

    /// Nothing at hand: is there anything to do?
    pub(super) fn choose(&mut self, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        self.memory.work = None;
        self.states.set(State::Idle, "nothing at hand", out);
        job.held = None;
        let facts = tick.facts(None);
        if facts.complete {
            if self.states.fire(Trigger::AllPlaced, facts, out) {
                finished(out);
            }
        } else if let Some(bin) = tick.scene.attached {
            self.adopt(bin, tick, job, out);
        } else if !tick.scene.cup_taken
            && let Some(bin) = tick.scene.next_bin()
            && self.states.fire(Trigger::GoPick, facts, out)
        {
            let kind = match tick.scene.bin(bin).map(|seen| lie(&seen.pose)) {
                Some(Lie::UpsideDown) => WorkKind::PickFlipped,
                _ => WorkKind::Pick,
            };
            self.begin(bin, kind, tick, job);
        }
    }

    pub(super) fn go_on(
        &mut self,
        mut work: Work,
        tick: &Tick<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let sequence = work.kind.sequence();
        let gone = tick.scene.bin(work.bin).is_none();
        if gone || (sequence.holds(work.step) && tick.scene.attached != Some(work.bin)) {
            self.lost(&work, tick, job, out);
            return;
        }
        let Some(step) = sequence.step(work.step) else {
            return;
        };
        if step == Step::ReachToPlace {
            creep(&mut work, tick);
            self.memory.work = Some(work);
        }
        let judge = Judge {
            setup: tick.setup,
            scene: &tick.scene,
            observation: tick.observation,
            motion: self.memory.motion.as_ref(),
        };
        match judge.progress(&work, step, job, out) {
            Progress::Running => {}
            Progress::Missed(failure) => self.missed(&work, failure, tick, job, out),
            Progress::Done if sequence.step(work.step + 1).is_some() => {
                self.enter(work, work.step + 1, tick, job, out);
            }
            Progress::Done => self.finish(&work, tick, job, out),
        }
    }

    /// Begins the first substep of `kind`.
    pub(super) fn begin(&mut self, bin: usize, kind: WorkKind, tick: &Tick<'_>, job: &mut Job) {
        let seen = tick.scene.bin(bin);
        let from_belt = seen.is_some_and(|seen| tick.scene.on_belt(&seen));
        let tool = KeptPose::from(&tick.scene.tool);
        let kind = match kind {
            WorkKind::Place if from_belt => WorkKind::PlaceFromBelt,
            kind => kind,
        };
        let mut work = Work {
            bin,
            kind,
            from_belt,
            step: 0,
            began: tick.now,
            refusals: tick.scene.refusals,
            base: tool,
            joints: tick.joints(),
            slot: None,
            creep: [0.0; 2],
        };
        if matches!(work.kind.sequence(), Sequence::Place { .. }) {
            tick.choose_place(&mut work);
            if work.slot.is_none() {
                job.fail(Failure::BinCannotBePlaced.reason());
            }
        }
        job.counters.phase_entry += 1;
        self.memory.work = Some(work);
    }

    pub(super) fn enter(
        &mut self,
        work: Work,
        step: usize,
        tick: &Tick<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let next = work.kind.sequence().step(step);
        let lifts = matches!(next, Some(Step::TimedLift | Step::LiftToClearance));
        let target = self.memory.motion.map(|motion| motion.target);
        self.memory.work = Some(Work {
            step,
            began: tick.now,
            refusals: tick.scene.refusals,
            base: target.filter(|_| lifts).unwrap_or(work.base),
            joints: tick.joints(),
            ..work
        });
        job.counters.phase_entry += 1;
        match next {
            Some(Step::CloseSuctionGripper) => out.log(format_args!("<close gripper>")),
            Some(Step::OpenSuctionGripper) => out.log(format_args!("<open gripper>")),
            _ => {}
        }
    }

    /// The last substep of a state is over.
    pub(super) fn finish(&mut self, work: &Work, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        let facts = tick.facts(Some(work.bin));
        let name = tick.setup.name(work.bin);
        let trigger = match work.kind {
            WorkKind::Pick | WorkKind::PickFlipped => {
                let word = if facts.needs_flip { "flip" } else { "no flip" };
                out.log(format_args!("<{word}> {name}"));
                tick.forgive_picks(work.bin, job);
                Trigger::PickDone
            }
            WorkKind::Flip => Trigger::FlipDone,
            WorkKind::Place | WorkKind::PlaceFromBelt | WorkKind::PlaceFromHome => {
                tick.judge_place(work, job, out);
                Trigger::PlaceDone
            }
        };
        if !self.states.fire(trigger, facts, out) {
            self.states.set(State::Idle, "no row", out);
        }
        self.memory.work = None;
        match self.states.state() {
            State::Picking => self.begin(work.bin, WorkKind::Pick, tick, job),
            State::Flipping => self.begin(work.bin, WorkKind::Flip, tick, job),
            State::Placing => self.begin(work.bin, WorkKind::Place, tick, job),
            State::Done => finished(out),
            State::Idle => {}
        }
    }

    pub(super) fn lost(&mut self, work: &Work, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        let name = tick.setup.name(work.bin);
        let sequence = work.kind.sequence();
        out.log(format_args!("[lost] {name} while {}", self.states.name()));
        if sequence.holds(work.step) {
            job.counters.drops += 1;
            if tick.count_failure(work, job) >= tick.setup.numbers.max_attempts {
                job.fail(Failure::BinCannotBeGripped.reason());
            }
        } else {
            job.counters.recoveries += 1;
        }
        self.back_to_idle(tick, job, out);
    }

    pub(super) fn missed(
        &mut self,
        work: &Work,
        failure: Failure,
        tick: &Tick<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let step = work.kind.sequence().step(work.step).map_or("", Step::name);
        let name = tick.setup.name(work.bin);
        out.log(format_args!("[missed] {name}: {step}"));
        job.counters.recoveries += 1;
        let holding = work.kind.sequence().holds(work.step);
        let again = tick.count_failure(work, job) < tick.setup.numbers.max_attempts;
        if !again || failure == Failure::GripperBlocked {
            job.fail(failure.reason());
        } else if holding {
            self.bring(work.bin, WorkKind::PlaceFromHome, tick, job, out);
        } else {
            self.back_to_idle(tick, job, out);
        }
    }

    pub(super) fn back_to_idle(&mut self, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        job.held = None;
        self.memory.work = None;
        job.counters.phase_entry += 1;
        if !self.states.fire(Trigger::Lost, tick.facts(None), out) {
            self.states.set(State::Idle, "lost", out);
        }
    }

    /// Goes on with a bin that is on the cup already.
    pub(super) fn adopt(&mut self, bin: usize, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        out.event(
            TraceEvent::Recover,
            format_args!("[resume] {} is on the cup", tick.setup.name(bin)),
        );
        job.counters.recoveries += 1;
        self.bring(bin, WorkKind::Place, tick, job, out);
    }

    /// The bin on the cup to the jig, or to its place by `way`.
    fn bring(
        &mut self,
        bin: usize,
        way: WorkKind,
        tick: &Tick<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let turned = tick.facts(Some(bin)).needs_flip;
        let (state, kind) = if turned {
            (State::Flipping, WorkKind::Flip)
        } else {
            (State::Placing, way)
        };
        self.states.set(state, "on the cup", out);
        self.begin(bin, kind, tick, job);
    }
}

/// A bin near its place moves the target by part of what is missing, in every
/// decision.
fn creep(work: &mut Work, tick: &Tick<'_>) {
    let numbers = &tick.setup.numbers.place;
    let (Some(slot), Some(bin)) = (
        work.slot.and_then(|slot| tick.setup.slots.get(slot)),
        tick.scene.bin(work.bin),
    ) else {
        return;
    };
    let off = slot.translation.vector - bin.pose.translation.vector;
    let low = off.z.abs() < numbers.creep_m;
    if off.xy().norm() >= numbers.creep_m || !low {
        return;
    }
    for (crept, missing) in work.creep.iter_mut().zip([off.x, off.y]) {
        *crept = (*crept + numbers.creep_gain * missing).clamp(-numbers.creep_m, numbers.creep_m);
    }
}

fn finished(out: &mut Output) {
    out.log(format_args!("<palletizing complete>"));
}
