//! The task: a policy, what it remembers, and the operator's panel.

use behavior::Graph;
use cell_model::Cell;
use ipc_types::decision::{CellIo, MAX_PLACED, Outcome};
use ipc_types::{ArmStatus, Decision, Header, OperatorPanel, Text, WorldState};
use serde::de::Error as _;

use crate::choice::choose;
use crate::job::Job;
use crate::observation::Observation;
use crate::operator::{PanelChange, PanelMemory, log_change};
use crate::output::{ArmIntent, Output, TraceLineText};
use crate::policy::Policy;
use crate::record::{self, RECORD_VERSION, RecordError, TaskRecord};
use crate::time::{PolicyClock, PolicyTime};
use crate::tracer::Tracer;

pub use crate::choice::TaskError;

/// Shown instead of a phase once the job was given up.
const FAILED: &str = "FAILED";

/// A task of a cell. [`Task::decide`] depends on its arguments and on the record
/// only, so a task made anew and restored goes on bit by bit.
pub struct Task {
    demo: String,
    arm_count: usize,
    grip_force: f64,
    /// Obstacles that are there; the others guide the policy, not the operator.
    solid_obstacles: u64,
    policy: Box<dyn Policy>,
    job: Job,
    clock: PolicyClock,
    panel: PanelMemory,
    out: Output,
    tracer: Tracer,
    /// Belief and world have to be compared before the next decision.
    unsure: bool,
}

impl Task {
    /// A task that has not begun, with the named policy.
    ///
    /// # Errors
    /// [`TaskError`] for a policy the demo does not have, with advice, and for a
    /// `[task]` table that does not fit the cell.
    pub fn new(cell: &Cell, policy: &str) -> Result<Self, TaskError> {
        let (policy, grip_force) = choose(cell, policy)?;
        let task = Self::with_policy(
            &cell.name,
            cell.arms.len(),
            cell.objects.len(),
            grip_force,
            policy,
        );
        Ok(Self {
            solid_obstacles: solid_obstacles(cell),
            ..task
        })
    }

    /// A task around any policy. `grip_force` is used when the operator closes
    /// the gripper (N).
    pub fn with_policy(
        demo: &str,
        arm_count: usize,
        object_count: usize,
        grip_force: f64,
        policy: Box<dyn Policy>,
    ) -> Self {
        Self {
            demo: demo.to_owned(),
            arm_count,
            grip_force,
            solid_obstacles: u64::MAX,
            tracer: Tracer::new(policy.as_ref()),
            policy,
            job: Job::new(object_count),
            clock: PolicyClock::default(),
            panel: PanelMemory::default(),
            out: Output::default(),
            unsure: true,
        }
    }

    /// One decision, to be called on every [`ipc_types::DECISION_TICKS`]th tick.
    /// `status` is indexed by arm. Fills `out` but for the parts of the header
    /// its writer knows, and appends to `trace`.
    pub fn decide(
        &mut self,
        state: &WorldState,
        status: &[Option<&ArmStatus>],
        out: &mut Decision,
        trace: &mut Vec<TraceLineText>,
    ) {
        let change = self.panel.update(&state.panel);
        let now = self.clock.advance(state.header.tick, self.panel.paused());
        let observation = Observation::new(state, status, now);
        self.out.begin();
        self.obey(change, &state.panel);
        let leads = self.panel.paused() && !self.policy.follows_operator();
        if leads {
            let (arm, intent) = self.panel.lead(&state.panel, self.grip_force);
            self.out.arm(
                arm,
                ArmIntent {
                    obstacle_mask: self.solid_obstacles,
                    ..intent
                },
            );
            self.out.phase = self.policy.phase();
            self.policy.tend(&observation, &mut self.job);
        } else {
            if std::mem::take(&mut self.unsure) {
                self.policy
                    .reconcile(&observation, &mut self.job, &mut self.out);
            }
            self.work(&observation);
        }
        if self.panel.paused() {
            self.out.outcome = Outcome::Paused;
        }
        self.tracer.changes(self.policy.as_ref(), &mut self.out);
        self.out.finish(self.arm_count, out, trace);
        self.fill(state.header.tick, out);
    }

    /// Everything the task remembers, as plain bytes; see [`Task::restore`].
    pub fn record(&self) -> Vec<u8> {
        record::to_bytes(&TaskRecord {
            version: RECORD_VERSION,
            demo: self.demo.clone(),
            policy: self.policy.name().to_owned(),
            job: self.job.clone(),
            clock: self.clock.clone(),
            panel: self.panel.clone(),
            goals: self.out.book().clone(),
            unsure: self.unsure,
            policy_state: self.policy.save(),
        })
    }

    /// Takes back what [`Task::record`] gave. The record of another policy of
    /// the same demo is taken, too: its job goes on, with what is in the hand.
    ///
    /// # Errors
    /// [`RecordError`], with the task unchanged, for a record that is damaged,
    /// of another version or of another cell.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RecordError> {
        let found = record::version(bytes)?;
        if found != RECORD_VERSION {
            return Err(RecordError::Version { found });
        }
        let record: TaskRecord = record::from_bytes(bytes)?;
        if record.demo != self.demo || !record.job.fits(self.job.attempts.len()) {
            return Err(RecordError::OtherCell {
                found: record.demo,
                expected: self.demo.clone(),
            });
        }
        if !record.is_sound() {
            let wrong = "it counts further than a run can get";
            return Err(bincode::Error::custom(wrong).into());
        }
        let same_policy = record.policy == self.policy.name();
        if same_policy {
            self.policy.restore(&record.policy_state)?;
        } else {
            self.policy.reset();
        }
        self.job.take(record.job);
        self.clock = record.clock;
        self.panel = record.panel;
        *self.out.book_mut() = record.goals;
        self.unsure = record.unsure || !same_policy;
        Ok(())
    }

    /// To be called once, before the next decision, when decisions were missed:
    /// that decision then compares what the record believes (what is in the
    /// hand, what was reached) with what it observes. The time without decisions,
    /// up to `state`, is no time of a phase: the arm held.
    pub fn reconcile(&mut self, state: &WorldState) {
        self.clock.skip_to(state.header.tick);
        self.unsure = true;
    }

    /// Forgets everything: the world is another one, and ticks count anew.
    pub fn begin_new_scene(&mut self) {
        self.policy.reset();
        self.job.reset();
        self.out.book_mut().forget();
        self.panel = PanelMemory::default();
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

    /// Appends how every node of them stands.
    pub fn trace_statuses(&mut self, lines: &mut Vec<TraceLineText>) {
        self.tracer.statuses(self.policy.as_ref(), lines);
    }

    /// Name of the policy.
    pub fn policy_name(&self) -> &'static str {
        self.policy.name()
    }

    /// Policy time of the last decision.
    pub fn time(&self) -> PolicyTime {
        self.clock.now()
    }

    fn obey(&mut self, change: PanelChange, panel: &OperatorPanel) {
        log_change(change, &mut self.out);
        if change.reset {
            self.policy.reset();
            self.job.reset();
            self.out.book_mut().forget();
            // Something may be in the hand.
            self.unsure = true;
            self.job.started = panel.task_started == 1;
        }
        self.job.started |= change.start;
        if change.start && self.job.failure.is_some() {
            self.job.retry();
            // Something may still be in the hand.
            self.unsure = true;
            self.out.lifecycle(format_args!("[task] started again"));
        }
        if change.resume {
            self.unsure = true;
        }
    }

    /// Lets the policy decide, unless the job was given up: then the arm holds
    /// and the gripper keeps what it has.
    fn work(&mut self, observation: &Observation<'_>) {
        if self.job.failure.is_none() {
            self.policy.tick(observation, &mut self.job, &mut self.out);
        } else {
            self.out.phase = Text::new(FAILED);
            self.policy.tend(observation, &mut self.job);
        }
        if let Some(failure) = self.job.failure {
            self.out.outcome = Outcome::Failed;
            self.out.reason = failure.reason();
        }
    }

    fn fill(&self, tick: u64, out: &mut Decision) {
        let counters = self.job.counters;
        out.header = Header::caused_by::<Decision>(tick);
        out.policy = Text::new(self.policy.name());
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
        out.placed = [0; MAX_PLACED];
        out.placed_count = 0;
        for (slot, object) in out.placed.iter_mut().zip(&self.job.placed) {
            *slot = *object;
            out.placed_count += 1;
        }
    }
}

/// Mask of the obstacles that are there in physics.
fn solid_obstacles(cell: &Cell) -> u64 {
    let guides = cell.obstacles().enumerate().filter(|(_, o)| !o.solid);
    guides.fold(u64::MAX, |mask, (bit, _)| mask & !(1 << bit.min(63)))
}
