//! The work on a bin, and the transition from step to step.

use nalgebra::UnitQuaternion;
use robocell_skills::{KeptPose, Named as _};
use robocell_task::job::Attempts;
use robocell_task::{Job, Output, TraceEvent};

use super::geometry::{self, Lie, lie};
use super::memory::Work;
use super::motion::{self, Judge, Progress};
use super::numbers::{Suction, Target};
use super::policy::Palletizer;
use super::scene::View;
use super::table::{Facts, State, Trigger};
use super::waits::{self, fail};
use super::work_kind::WorkKind;
use crate::failure::Failure;

/// A bin nearer than this to its place is set down there (m).
const COMMITTED_M: f64 = 0.05;

impl Palletizer {
    pub(super) fn advance(&mut self, view: &View<'_>, job: &mut Job, out: &mut Output) {
        // Done is final: a bin that is pulled off the pallet afterwards does not restart the
        // job.
        match (self.state(), self.memory.work) {
            (State::Done, _) => {}
            (State::Idle, _) | (_, None) => self.choose(view, job, out),
            (_, Some(work)) => self.work_on(work, view, job, out),
        }
    }

    fn fire(&mut self, trigger: Trigger, mut facts: Facts, out: &mut Output) -> bool {
        self.run.fire(trigger.name(), &mut facts, out)
    }

    fn set(&mut self, state: State, why: &str, out: &mut Output) {
        self.run.set(state.name(), why, out);
    }

    /// Nothing is in progress: chooses the next work, if there is any.
    fn choose(&mut self, view: &View<'_>, job: &mut Job, out: &mut Output) {
        // Nothing of the last bin may remain, on every path to here.
        self.memory.work = None;
        self.set(State::Idle, "nothing at hand", out);
        job.held = None;
        let facts = view.facts(None);
        if facts.complete {
            if self.fire(Trigger::AllPlaced, facts, out) {
                finished(out);
            }
        // A bin on the cup goes first, whatever put it there: the arm cannot pick another one.
        } else if let Some(bin) = view.attached {
            self.adopt(bin, view, job, out);
        // Something else on the cup: suction could not attach a bin.
        } else if !view.cup_taken
            && let Some(bin) = waits::next_bin(view, job, out)
            && self.fire(Trigger::GoPick, facts, out)
        {
            // A bin that opens downward is gripped on its bottom, which is another sequence of
            // steps.
            let kind = match view.bin(bin).map(|seen| lie(&seen.pose)) {
                Some(Lie::UpsideDown) => WorkKind::PickFlipped,
                _ => WorkKind::Pick,
            };
            self.begin(bin, kind, view, job);
        }
    }

    fn work_on(&mut self, mut work: Work, view: &View<'_>, job: &mut Job, out: &mut Output) {
        let sequence = view.setup.sequence(work.kind);
        // Checked before the step itself: a step that waits or moves would continue without its
        // bin.
        let gone = view.bin(work.bin).is_none();
        if gone || (sequence.holds(work.step) && view.attached != Some(work.bin)) {
            self.lost(&work, view, job, out);
            return;
        }
        if work.kind.places() && self.changes_place(&mut work, view, job, out) {
            return;
        }
        let Some(step) = sequence.step(work.step) else {
            return;
        };
        let to = step.table.go.as_ref().map(|go| go.to);
        // Only on the way into a slot: the target is corrected by the observed error of the
        // bin.
        if matches!(to, Some(Target::Slot { .. })) {
            motion::creep(&mut work, view);
            self.memory.work = Some(work);
        }
        let memory = &self.memory;
        let judge = Judge {
            view,
            memory,
            job,
            out,
        };
        match judge.progress(&work, step) {
            Progress::Running => {}
            Progress::Missed(failure) => self.missed(&work, failure, view, job, out),
            Progress::Done if sequence.step(work.step + 1).is_some() => {
                self.enter(work, view, job, out);
            }
            Progress::Done => self.finish(&work, view, job, out),
        }
    }

    /// Whether the bin on the cup waits for a place, or goes to another one because a person put a
    /// bin into its own.
    fn changes_place(
        &mut self,
        work: &mut Work,
        view: &View<'_>,
        job: &mut Job,
        out: &mut Output,
    ) -> bool {
        let sequence = view.setup.sequence(work.kind);
        if !sequence.holds(work.step) {
            return false;
        }
        let Some(slot) = work.slot else {
            if waits::for_place(work, view, job, out) {
                self.bring(work.bin, WorkKind::PlaceFromHome, view, job, out);
            }
            return true;
        };
        let off = view.off_place(work).map_or(0.0, |off| off.norm());
        // So near to its place it touches whatever is in it: to lift it again would not help.
        let blocker = (off > COMMITTED_M).then(|| view.blocker(work.bin, slot));
        let Some(other) = blocker.flatten() else {
            return false;
        };
        let (name, other) = (view.setup.name(work.bin), view.setup.name(other));
        let place = slot + 1;
        out.event(
            TraceEvent::Recover,
            format_args!("[taken] {name}: place {place} is taken by {other}"),
        );
        job.counters.recoveries += 1;
        self.bring(work.bin, WorkKind::PlaceFromHome, view, job, out);
        true
    }

    /// Starts the first step of `kind`.
    fn begin(&mut self, bin: usize, kind: WorkKind, view: &View<'_>, job: &mut Job) {
        let from_belt = view.bin(bin).is_some_and(|seen| view.on_belt(&seen));
        let kind = match kind {
            WorkKind::Place if from_belt => WorkKind::PlaceFromBelt,
            kind => kind,
        };
        let mut work = Work {
            bin,
            kind,
            from_belt,
            step: 0,
            began: view.now,
            refusals: view.refusals,
            base: KeptPose::from(&view.tool),
            joints: view.joints,
            slot: None,
            creep: [0.0; 2],
        };
        // Sequences that place need a slot from their first step on; without one they wait.
        if kind.places() {
            choose_place(&mut work, view);
        }
        // A new key is a new goal: the controller must not count the arrival at the last one.
        job.newest_key += 1;
        self.memory.work = Some(work);
    }

    /// Starts the next step.
    fn enter(&mut self, work: Work, view: &View<'_>, job: &mut Job, out: &mut Output) {
        let step = work.step + 1;
        let next = view.setup.sequence(work.kind).step(step);
        let to = next.and_then(|next| Some(next.table.go.as_ref()?.to));
        // Steps relative to the target before start from the target, not from the tool, which
        // lags behind and would add its error to each step.
        let relative = matches!(to, Some(Target::Up { .. } | Target::Back { .. }));
        let target = self.memory.path.end().filter(|_| relative);
        self.memory.work = Some(Work {
            step,
            began: view.now,
            refusals: view.refusals,
            base: target.map_or(work.base, |target| target.pose().into()),
            joints: view.joints,
            ..work
        });
        job.newest_key += 1;
        match next.and_then(|next| next.table.suction) {
            Some(Suction::On) => out.log(format_args!("<close gripper>")),
            Some(Suction::Off) => out.log(format_args!("<open gripper>")),
            None => {}
        }
    }

    /// Ends a state after its last step.
    fn finish(&mut self, work: &Work, view: &View<'_>, job: &mut Job, out: &mut Output) {
        let facts = view.facts(Some(work.bin));
        let name = view.setup.name(work.bin);
        let trigger = if work.kind.picks() {
            let word = if facts.needs_flip { "flip" } else { "no flip" };
            out.log(format_args!("<{word}> {name}"));
            // A successful pick ends the count of failures, which is in a row.
            if let Some(attempts) = attempts(work, view, job) {
                attempts.pick = 0;
            }
            Trigger::PickDone
        } else if work.kind == WorkKind::Flip {
            Trigger::FlipDone
        } else {
            judge_place(work, view, job, out);
            Trigger::PlaceDone
        };
        // The file may have no row for this state and trigger; the job then chooses again
        // instead of waiting for ever.
        if !self.fire(trigger, facts, out) {
            self.set(State::Idle, "no row", out);
        }
        // Which sequence follows is the table's decision: its state, not the trigger, is looked
        // at.
        self.memory.work = None;
        match self.state() {
            State::Picking => self.begin(work.bin, WorkKind::Pick, view, job),
            State::Flipping => self.begin(work.bin, WorkKind::Flip, view, job),
            State::Placing => self.begin(work.bin, WorkKind::Place, view, job),
            State::Done => finished(out),
            State::Idle => {}
        }
    }

    fn lost(&mut self, work: &Work, view: &View<'_>, job: &mut Job, out: &mut Output) {
        let name = view.setup.name(work.bin);
        // A bin that was lost from the cup is a drop; one that disappeared before it was
        // gripped is not.
        let held = view.setup.sequence(work.kind).holds(work.step);
        let event = if held {
            TraceEvent::Drop
        } else {
            TraceEvent::Recover
        };
        out.event(
            event,
            format_args!("[lost] {name} while {}", self.run.state()),
        );
        if held {
            job.counters.drops += 1;
            // A bin that falls again and again would make an endless job.
            if count_failure(work, view, job) >= view.setup.task.max_attempts {
                let why = format_args!("{name} was lost again and again");
                fail(Failure::BinCannotBeHeld, why, job, out);
            }
        } else {
            job.counters.recoveries += 1;
        }
        self.back_to_idle(view, job, out);
    }

    fn missed(
        &mut self,
        work: &Work,
        failure: Failure,
        view: &View<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let sequence = view.setup.sequence(work.kind);
        let step = sequence.step(work.step).map_or("", |step| &step.phase);
        let name = view.setup.name(work.bin);
        out.event(TraceEvent::Recover, format_args!("[missed] {name}: {step}"));
        job.counters.recoveries += 1;
        let again = count_failure(work, view, job) < view.setup.task.max_attempts;
        // A gripper that does not open stays closed in another attempt, too.
        if !again || failure == Failure::GripperBlocked {
            let why = format_args!("{name}: {step} was missed again and again");
            fail(failure, why, job, out);
        // The bin is still on the cup: it is carried over the rest pose instead, another way to
        // its place.
        } else if sequence.holds(work.step) {
            self.bring(work.bin, WorkKind::PlaceFromHome, view, job, out);
        } else {
            self.back_to_idle(view, job, out);
        }
    }

    fn back_to_idle(&mut self, view: &View<'_>, job: &mut Job, out: &mut Output) {
        job.held = None;
        self.memory.work = None;
        // The goal of the old work must not be followed any longer.
        job.newest_key += 1;
        if !self.fire(Trigger::Lost, view.facts(None), out) {
            self.set(State::Idle, "lost", out);
        }
    }

    /// Continues with a bin that is already on the cup.
    pub(super) fn adopt(&mut self, bin: usize, view: &View<'_>, job: &mut Job, out: &mut Output) {
        let name = view.setup.name(bin);
        out.event(
            TraceEvent::Recover,
            format_args!("[resume] {name} is on the cup"),
        );
        job.counters.recoveries += 1;
        self.bring(bin, WorkKind::Place, view, job, out);
    }

    /// Takes the bin on the cup to the jig, or to its place by `way`.
    fn bring(
        &mut self,
        bin: usize,
        way: WorkKind,
        view: &View<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let (state, kind) = if view.facts(Some(bin)).needs_flip {
            (State::Flipping, WorkKind::Flip)
        } else {
            (State::Placing, way)
        };
        self.set(state, "on the cup", out);
        self.begin(bin, kind, view, job);
    }
}

/// Chooses the slot of the bin on the cup, and the tool's pose there.
fn choose_place(work: &mut Work, view: &View<'_>) {
    work.slot = view.free_slot(work.bin).ok();
    let slot = work.slot.and_then(|slot| view.setup.slots.get(slot));
    let (Some(slot), Some(bin)) = (slot, view.bin(work.bin)) else {
        return;
    };
    // The bin's pose in the cup is measured, so a bin gripped off its centre is placed centred.
    let grip = view.tool.inverse() * bin.pose;
    // Of two turns the one nearer to where the arm will be before it lowers the bin.
    let from: &UnitQuaternion<f64> = match work.kind {
        WorkKind::PlaceFromHome => &view.setup.home.rotation,
        _ => &view.tool.rotation,
    };
    work.base = KeptPose::from(&geometry::place(slot, &grip, from));
}

fn attempts<'j>(work: &Work, view: &View<'_>, job: &'j mut Job) -> Option<&'j mut Attempts> {
    job.attempts_mut(0, view.setup.bins.get(work.bin)?.object)
}

/// Counts a failure with a bin; returns how many in a row there are of its kind.
fn count_failure(work: &Work, view: &View<'_>, job: &mut Job) -> u32 {
    let Some(attempts) = attempts(work, view, job) else {
        return u32::MAX;
    };
    let count = if work.kind.picks() {
        &mut attempts.pick
    } else {
        &mut attempts.place
    };
    *count += 1;
    *count
}

/// Judges whether the released bin is in its place.
fn judge_place(work: &Work, view: &View<'_>, job: &mut Job, out: &mut Output) {
    let name = view.setup.name(work.bin);
    let slot = view.bin(work.bin).and_then(|seen| view.slot_of(&seen));
    if let Some(slot) = slot {
        // In its place: both counts of failures start again.
        if let Some(attempts) = attempts(work, view, job) {
            *attempts = Attempts::default();
        }
        out.log(format_args!("[placed] {name} in place {}", slot + 1));
        return;
    }
    out.log(format_args!("[missed] {name} is not in its place"));
    job.counters.recoveries += 1;
    if count_failure(work, view, job) >= view.setup.task.max_attempts {
        let why = format_args!("{name} does not stay in its place");
        fail(Failure::BinCannotBePlaced, why, job, out);
    }
}

fn finished(out: &mut Output) {
    out.log(format_args!("<palletizing complete>"));
}
