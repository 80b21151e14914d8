//! The task: a policy, its memory, and the operator's panel.
//!
//! [`Task::decide`] is one decision. Its order is fixed, and each step relies on the one
//! before: the panel (a pause stops the policy's clock), the clock, perception, the
//! operator's requests, then either the operator's intents or the policy, then trace,
//! goals, counters and breakpoints, and at the end validation of the whole message.
//!
//! What can go wrong here, and the rule that prevents it:
//! - a decision that depends on anything but its arguments and the checkpoint (a clock, a
//!   cache, the order of a hash map): the restored task decides differently and a replay
//!   reports a difference. All state of a task is in [`Task::checkpoint`];
//! - memory and world disagree, after missed decisions, a pause or a change of the policy:
//!   `unsure` makes the next decision of the policy reconcile before it commands the arm;
//! - a policy that computes NaN: readers drop such a message, and without `refuse` the cell
//!   would wait for a decision for ever;
//! - a job that failed must not move the arm: from then on only `tend` is called, so belts
//!   still stop where a bin waits.
//!
//! A new field of [`Task`] that changes between decisions belongs into the checkpoint, and
//! its version has to be increased.

use behavior::Graph;
use cell_model::Cell;
use ipc_types::decision::{CellIo, MAX_PLACED, Outcome};
use ipc_types::trace::TraceEvent;
use ipc_types::{
    ArmStatus, Decision, Header, Invalid, MAX_JOINTS, OperatorPanel, Text, Validate as _,
    WorldState,
};
use serde::de::Error as _;

use crate::breakpoints::{Breakpoints, Happened};
use crate::checkpoint::{self, CheckpointError, TaskCheckpoint, VERSION};
use crate::job::Job;
use crate::observation::Observation;
use crate::operator::{PanelChange, PanelState, log_change};
use crate::output::{ArmIntent, Output, TraceLineText};
use crate::perception::Perception;
use crate::policy::AnyPolicy;
use crate::time::{PolicyClock, PolicyTime};
use crate::trace::Tracer;

/// Shown in place of a phase once the job has failed.
const FAILED: &str = "FAILED";

/// Reason of a job whose policy made a decision that is not a valid message.
const INVALID_DECISION: &str = "invalid_decision";

/// A task of a cell. [`Task::decide`] depends on its arguments and on the
/// checkpoint only, so a new task that is restored decides the same, bit by bit.
pub struct Task {
    demo: String,
    name: String,
    arm_count: usize,
    /// By arm: its joints at the start (rad or m).
    homes: Vec<[f64; MAX_JOINTS]>,
    grip_force: f64,
    /// Mask of the solid obstacles; the others guide the policy, not the operator.
    solid_obstacles: u64,
    policy: Box<dyn AnyPolicy>,
    job: Job,
    /// The phase that was counted last.
    phase: Text<32>,
    clock: PolicyClock,
    panel: PanelState,
    breakpoints: Breakpoints,
    out: Output,
    tracer: Tracer,
    perception: Perception,
    /// Reported with the first decision.
    warnings: Vec<String>,
    /// Memory and world have to be compared before the next decision.
    unsure: bool,
    /// Result of the last restore, until the next decision.
    restored: Restored,
}

/// What [`Task::restore`] took from a checkpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Restored {
    /// The job and the memory of the policy.
    #[default]
    All,
    /// The job: the checkpoint is of another policy.
    OtherPolicy,
    /// The job: nothing of the policy's memory was restored.
    NoMemory,
}

impl Restored {
    /// A line for the log.
    pub fn line(self) -> &'static str {
        match self {
            Self::All => "[task] resumed from its checkpoint",
            Self::OtherPolicy => "[task] another policy took over the job",
            Self::NoMemory => {
                "[task] the policy starts again: nothing of its memory was kept; the job continues"
            }
        }
    }
}

impl Task {
    /// The task of `cell` with a policy of that name, before its first decision.
    /// `grip_force` is used when the operator closes the gripper (N).
    pub fn new(cell: &Cell, name: &str, grip_force: f64, policy: Box<dyn AnyPolicy>) -> Self {
        let warnings = policy.warnings(cell);
        Self {
            demo: cell.name.clone(),
            name: name.to_owned(),
            arm_count: cell.arms.len(),
            homes: cell.arms.iter().map(|arm| joints(&arm.home)).collect(),
            grip_force,
            solid_obstacles: solid_obstacles(cell),
            tracer: Tracer::new(policy.as_ref(), name),
            policy,
            job: Job::new(cell.objects.len()),
            phase: Text::EMPTY,
            clock: PolicyClock::default(),
            panel: PanelState::default(),
            breakpoints: Breakpoints::default(),
            out: Output::default(),
            perception: Perception::new(cell),
            warnings,
            // A task may start with an object in the gripper, after a kill without a
            // checkpoint.
            unsure: true,
            restored: Restored::All,
        }
    }

    /// One decision, to be called on every [`ipc_types::DECISION_TICKS`]th tick.
    /// `status` is indexed by arm. Fills `out` except for the parts of the header
    /// that its publisher sets, and appends to `trace`.
    pub fn decide(
        &mut self,
        state: &WorldState,
        status: &[Option<&ArmStatus>],
        out: &mut Decision,
        trace: &mut Vec<TraceLineText>,
    ) {
        self.restored = Restored::All;
        // The panel comes before the clock: time in which the task is paused does not count, so
        // no deadline of a policy passes while the operator moves the arm.
        let change = self.panel.update(&state.panel, state.header.tick);
        let now = self.clock.advance(state.header.tick, self.panel.paused());
        // Taken out, since the observation borrows it while the task itself is changed below.
        let mut perception = std::mem::take(&mut self.perception);
        let observation = Observation::new(perception.see(state), status, now);
        self.out.begin();
        if change.first {
            self.warn();
        }
        self.obey(change, &state.panel);
        // `entries` and `from` mark what this decision adds, for the count of phases and for
        // breakpoints, which must not be reached again by lines of an earlier decision.
        let (entries, from) = (self.job.counters.phase_entry, trace.len());
        // While the operator moves the arm the policy does not decide: its goals would compete.
        if self.is_led(&state.panel) {
            self.lead(&state.panel, state.header.tick);
            self.out.phase = self.policy.phase();
            self.policy.tend(&observation, &mut self.job);
        } else {
            // Taken, not read: one reconciliation is enough, whether or not it finds a
            // difference.
            if std::mem::take(&mut self.unsure) {
                self.policy
                    .reconcile(&observation, &mut self.job, &mut self.out);
            }
            self.work(&observation);
            self.count_phase(entries);
        }
        self.perception = perception;
        if self.panel.paused() {
            self.out.outcome = Outcome::Paused;
        }
        // After the policy, which has changed the status of its nodes by now.
        self.tracer.changes(self.policy.as_ref(), &mut self.out);
        self.out.finish(self.arm_count, out, trace);
        self.fill(state.header.tick, out);
        let entered = self.job.counters.phase_entry != entries;
        let happened = Happened {
            graphs: self.tracer.graphs(),
            lines: trace.get(from..).unwrap_or_default(),
            entered: entered.then(|| self.out.phase.as_str()),
        };
        let (panel, tick) = (&state.panel, state.header.tick);
        // Last before the check: it needs the lines and the phase of this decision.
        self.breakpoints.update(panel, tick, &happened, out);
        // Validated by the rule of the readers: a refused decision would be sent and dropped.
        if let Err(invalid) = out.validate() {
            self.refuse(&invalid, out, trace);
        }
    }

    /// Warnings are in the trace, so the log, the page and a recording have them alike.
    fn warn(&mut self) {
        for warning in &self.warnings {
            self.out
                .lifecycle(TraceEvent::None, format_args!("[warning] {warning}"));
        }
    }

    /// Readers drop an invalid decision, so no process would learn that the job cannot be
    /// done: instead, the arm holds and the job fails.
    fn refuse(&mut self, invalid: &Invalid, out: &mut Decision, trace: &mut Vec<TraceLineText>) {
        let tick = out.header.tick;
        self.job.fail(INVALID_DECISION);
        // The intents that made the decision invalid are cleared; nothing of it is published.
        self.out.begin();
        self.out.event(
            TraceEvent::Fault,
            format_args!("[fault] the policy's decision is refused: {invalid}; the arm holds"),
        );
        self.report_failure();
        self.out.finish(self.arm_count, out, trace);
        self.fill(tick, out);
    }

    /// The whole state of the task, as plain bytes; see [`Task::restore`].
    pub fn checkpoint(&self) -> Vec<u8> {
        checkpoint::to_bytes(&TaskCheckpoint {
            version: VERSION,
            demo: self.demo.clone(),
            policy: self.name.clone(),
            job: self.job.clone(),
            phase: self.phase.as_str().to_owned(),
            clock: self.clock.clone(),
            panel: self.panel.clone(),
            goals: self.out.book().clone(),
            breakpoints: self.breakpoints.clone(),
            unsure: self.unsure,
            policy_state: self.policy.save(),
        })
    }

    /// Restores what [`Task::checkpoint`] returned. The checkpoint of another policy of the
    /// same demo is accepted, too: its job is resumed, with the object in the gripper.
    ///
    /// # Errors
    /// [`CheckpointError`] for a checkpoint that is damaged, of another version or of another
    /// cell. The task is unchanged then, except that a policy whose own bytes do not decode
    /// is reset.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        // The version is read before the rest, whose layout it determines.
        let found = checkpoint::version(bytes)?;
        if found != VERSION {
            return Err(CheckpointError::Version { found });
        }
        let saved: TaskCheckpoint = checkpoint::from_bytes(bytes)?;
        // An edited cell with another number of objects would give indices another meaning.
        if saved.demo != self.demo || !saved.job.fits(self.job.attempts.len()) {
            return Err(CheckpointError::OtherCell {
                found: saved.demo,
                expected: self.demo.clone(),
            });
        }
        // Checked before the first assignment. A policy whose own bytes do not decode is reset,
        // all else is unchanged.
        if !saved.is_sound() {
            let wrong = "it counts further than a run can get";
            return Err(bincode::Error::custom(wrong).into());
        }
        let same_policy = saved.policy == self.name;
        if same_policy {
            // The memory of another policy is not readable for this one, its job is: that is
            // why the job is kept apart from the memory.
            self.policy.restore(&saved.policy_state)?;
            self.phase = Text::new(&saved.phase);
        } else {
            self.policy.reset();
            self.phase = Text::EMPTY;
        }
        self.job.take(saved.job);
        self.clock = saved.clock;
        self.panel = saved.panel;
        self.breakpoints = saved.breakpoints;
        *self.out.book_mut() = saved.goals;
        // The sentence is not in the checkpoint; one of before would explain another failure.
        self.out.forget_message();
        // Another policy has an empty memory and may have an object in the gripper.
        self.unsure = saved.unsure || !same_policy;
        self.restored = match (same_policy, self.policy.has_resumed()) {
            (false, _) => Restored::OtherPolicy,
            (true, false) => Restored::NoMemory,
            (true, true) => Restored::All,
        };
        Ok(())
    }

    /// What [`Task::restore`] took from the checkpoint, until the next decision.
    pub fn restored(&self) -> Restored {
        self.restored
    }

    /// To be called once, before the next decision, when decisions were missed: that decision
    /// then compares the checkpoint (the held object, the goals reached) with the
    /// observation. The time without decisions, up to `state`, does not count as time of a
    /// phase: the arm held.
    pub fn reconcile(&mut self, state: &WorldState) {
        self.clock.skip_to(state.header.tick);
        self.unsure = true;
    }

    /// Resets everything: the world is another one, and ticks start from zero.
    pub fn begin_new_scene(&mut self) {
        self.policy.reset();
        // The goal numbers continue: a controller that was not restarted has latched the old
        // ones.
        self.job.reset();
        self.phase = Text::EMPTY;
        self.out.book_mut().forget();
        self.out.forget_message();
        self.panel = PanelState::default();
        self.clock = PolicyClock::default();
        self.unsure = true;
    }

    /// The pictures of the policy.
    pub fn graphs(&self) -> &[Graph] {
        self.tracer.graphs()
    }

    /// Appends the pictures of the policy as trace lines.
    pub fn trace_pictures(&self, lines: &mut Vec<TraceLineText>) {
        self.tracer.pictures(lines);
    }

    /// Appends the statuses of all nodes.
    pub fn trace_statuses(&mut self, lines: &mut Vec<TraceLineText>) {
        self.tracer.statuses(self.policy.as_ref(), lines);
    }

    /// Why the job was given up, or else the newest fault, in a sentence. `None` where
    /// the log had no line about it.
    pub fn message(&self) -> Option<&str> {
        self.out.message()
    }

    /// Whether the job was given up.
    pub fn has_failed(&self) -> bool {
        self.job.failure.is_some()
    }

    /// Probable mistakes in the files of the job.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Name of the policy.
    pub fn policy_name(&self) -> &str {
        &self.name
    }

    /// Policy time of the last decision.
    pub fn time(&self) -> PolicyTime {
        self.clock.now()
    }

    /// Whether the arms follow the operator instead of the policy.
    fn is_led(&self, panel: &OperatorPanel) -> bool {
        // A policy whose job are the operator's targets keeps the arm in a pause, except for
        // the return to the default pose after a reset.
        let returns = (0..self.arm_count).any(|arm| self.panel.returns(panel, arm));
        self.panel.paused() && (returns || !self.policy.follows_operator())
    }

    /// The arm that the operator's panel names follows the operator; after a reset of the
    /// task the others return to their default pose.
    fn lead(&mut self, panel: &OperatorPanel, tick: u64) {
        // Obstacles that are not solid guide the paths of a policy; the operator may want to
        // move the arm through them.
        let obstacle_mask = self.solid_obstacles;
        let (led, asked) = self.panel.lead(panel, self.grip_force);
        for (arm, home) in self.homes.iter().enumerate() {
            let intent = if self.panel.returns(panel, arm) {
                let pose = self.policy.default_pose(arm);
                self.panel.to_default(panel, tick, pose, *home)
            } else if arm == led {
                asked
            } else {
                // No intent: the arm holds and keeps its gripper.
                continue;
            };
            self.out.arm(
                arm,
                ArmIntent {
                    obstacle_mask,
                    ..intent
                },
            );
        }
    }

    fn obey(&mut self, change: PanelChange, panel: &OperatorPanel) {
        log_change(change, &mut self.out);
        if change.reset {
            self.policy.reset();
            self.job.reset();
            self.phase = Text::EMPTY;
            // `forget` and not a new book: goal numbers must not repeat.
            self.out.book_mut().forget();
            self.out.forget_message();
            // The gripper may hold an object.
            self.unsure = true;
            // A level of the panel: a job that was started before the reset waits for no second
            // start.
            self.job.started = panel.task_started == 1;
        }
        self.job.started |= change.start;
        if change.start && self.job.failure.is_some() {
            self.job.retry();
            self.out.forget_message();
            // The gripper may still hold an object.
            self.unsure = true;
            self.out
                .lifecycle(TraceEvent::Restart, format_args!("[task] started again"));
        }
        if change.resume {
            // The operator may have moved the arm, an object, or the gripper.
            self.unsure = true;
        }
    }

    /// Runs the policy, unless the job has failed: then the arm holds and the gripper keeps
    /// its state.
    fn work(&mut self, observation: &Observation<'_>) {
        if self.job.failure.is_none() {
            self.policy
                .decide(observation, &mut self.job, &mut self.out);
            // The reason without a fault of this decision has no sentence of its own.
            if self.job.failure.is_some() && !self.out.has_fault() {
                // An earlier fault is not the reason.
                self.out.forget_message();
            }
        } else {
            self.out.phase = Text::new(FAILED);
            // The equipment is still controlled: a belt has to stop where a bin waits.
            self.policy.tend(observation, &mut self.job);
        }
        self.report_failure();
    }

    /// Counts the entry into another phase, unless the policy counted it: `entries` is the
    /// count before its decision.
    fn count_phase(&mut self, entries: u32) {
        // A policy counts an entry into the phase it was in already, which the name hides.
        if self.out.phase != self.phase && self.job.counters.phase_entry == entries {
            self.job.counters.phase_entry += 1;
        }
        self.phase = self.out.phase;
    }

    fn report_failure(&mut self) {
        if let Some(failure) = self.job.failure {
            self.out.outcome = Outcome::Failed;
            self.out.reason = failure.text();
        }
    }

    fn fill(&self, tick: u64, out: &mut Decision) {
        let counters = self.job.counters;
        out.header = Header::caused_by::<Decision>(tick);
        out.policy = Text::new(&self.name);
        out.phase_entry = counters.phase_entry;
        out.drops = counters.drops;
        out.resyncs = counters.resyncs;
        out.aborts = counters.aborts;
        out.recoveries = counters.recoveries;
        let io = self.job.io;
        out.io = CellIo {
            conveyor_running: u32::from(io.conveyor_running),
            drop_parts: io.drop_parts,
            add_bin: io.add_bin,
            reserved: 0,
        };
        // Zeroed first: unused slots of equal decisions are equal, which a replay compares.
        out.placed = [0; MAX_PLACED];
        out.placed_count = 0;
        for (slot, object) in out.placed.iter_mut().zip(&self.job.placed) {
            *slot = *object;
            out.placed_count += 1;
        }
    }
}

/// Joint positions as a message has them (rad or m), with zeros for missing joints.
fn joints(positions: &[f64]) -> [f64; MAX_JOINTS] {
    let mut all = [0.0; MAX_JOINTS];
    for (slot, position) in all.iter_mut().zip(positions) {
        *slot = *position;
    }
    all
}

/// Mask of the obstacles that are solid in physics.
fn solid_obstacles(cell: &Cell) -> u64 {
    // A goal has 64 bits; a cell has at most 64 fixtures, so `min` only guards the shift.
    let guides = cell.obstacles().enumerate().filter(|(_, o)| !o.solid);
    guides.fold(u64::MAX, |mask, (bit, _)| mask & !(1 << bit.min(63)))
}
