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

mod panel;
mod state;

use std::ops::Range;

use behavior::Graph;
use cell_model::Cell;
use cell_model::runs::policy_server::ServerReport;
use ipc_types::decision::{CellIo, MAX_PLACED, Outcome};
use ipc_types::trace::TraceEvent;
use ipc_types::{
    ArmStatus, Decision, Header, Invalid, MAX_JOINTS, Text, Validate as _, WorldState,
};

use crate::breakpoints::{Breakpoints, Happened};
use crate::job::Job;
use crate::observation::Observation;
use crate::operator::PanelState;
use crate::output::{Output, TraceLineText};
use crate::perception::Perception;
use crate::policy::AnyPolicy;
use crate::time::{PolicyClock, PolicyTime};
use crate::trace::Tracer;

pub use state::Restored;

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
        let observation = Observation::new(perception.observe(state), status, now);
        self.out.begin();
        if change.first {
            self.warn();
        }
        self.apply(change, &state.panel);
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
        // Last before the check: it needs the lines and the phase of this decision.
        let lines = trace.get(from..).unwrap_or_default();
        self.reach_breakpoints(state, entries, lines, out);
        // Validated by the rule of the readers: a refused decision would be sent and dropped.
        if let Err(invalid) = out.validate() {
            self.refuse(&invalid, out, trace);
        }
    }

    /// Looks for a breakpoint in `lines` of this decision and in its phase: `entries` is the
    /// count of phases before it.
    fn reach_breakpoints(
        &mut self,
        state: &WorldState,
        entries: u32,
        lines: &[TraceLineText],
        out: &mut Decision,
    ) {
        let entered = self.job.counters.phase_entry != entries;
        let happened = Happened {
            graphs: self.tracer.graphs(),
            lines,
            entered: entered.then(|| self.out.phase.as_str()),
        };
        let (panel, tick) = (&state.panel, state.header.tick);
        self.breakpoints.update(panel, tick, &happened, out);
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

    /// See [`AnyPolicy::server_report`].
    pub fn server_report(&self) -> Option<ServerReport> {
        self.policy.server_report()
    }

    /// See [`AnyPolicy::take_warnings`].
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.policy.take_warnings()
    }

    /// The pictures of the policy.
    pub fn graphs(&self) -> &[Graph] {
        self.tracer.graphs()
    }

    /// Number of trace lines of the pictures of the policy.
    pub fn picture_lines(&self) -> usize {
        self.tracer.picture_lines()
    }

    /// Appends those trace lines of the pictures of the policy.
    pub fn trace_pictures(&self, range: Range<usize>, lines: &mut Vec<TraceLineText>) {
        self.tracer.pictures(range, lines);
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
