//! Verification of the task: its decisions are computed a second time.

use std::collections::VecDeque;

use cell_model::Cell;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmStatus, Decision, MAX_ARMS, Wire, WorldState};
use robocell_task::starts::{Decider, History, Kept};
use robocell_task::{Policies, TaskError};

use super::VerifyError;
use super::difference::{Difference, first_byte};
use super::inputs::{Checkpoint, Checkpoints, Inputs, input};
use super::message_window::{Key, PATIENCE, Step, key};
use super::report::{Report, compare};

/// Compares the recorded decisions with computed ones.
pub(super) struct TaskCheck<'a> {
    policies: &'a Policies,
    cell: &'a Cell,
    /// Policy with which the run started.
    policy: &'a str,
    waiting: VecDeque<Box<Decision>>,
    running: Option<Running>,
    /// The newest computed decision.
    last: Option<Decision>,
    state: Box<WorldState>,
    history: Computed,
    doubts: Vec<Doubt>,
}

/// Computed checkpoints for the states that physics saved.
#[derive(Default)]
struct Computed(Vec<Kept>);

/// As many as a task process keeps (`HISTORY` in `task-program`): with more, a task that goes
/// back with physics would find a checkpoint here that the process had replaced already.
const HISTORY: usize = 4;

impl History for Computed {
    fn at(&self, tick: u64) -> Option<Kept> {
        let found = self.0.iter().rev().find(|kept| kept.tick <= tick)?;
        Some(Kept {
            tick: found.tick,
            checkpoint: found.checkpoint.clone(),
        })
    }

    fn keep(&mut self, tick: u64, saved_tick: u64, checkpoint: &dyn Fn() -> Vec<u8>) {
        // Physics went back before these: they belong to ticks that are computed a second time.
        self.0.retain(|kept| kept.tick < tick);
        // The checkpoint for the saved state is never replaced: physics resumes from it after a
        // kill.
        let needed = self.0.iter().rposition(|kept| kept.tick <= saved_tick);
        if self.0.len() >= HISTORY {
            self.0.remove(usize::from(needed == Some(0)));
        }
        let checkpoint = checkpoint();
        self.0.push(Kept { tick, checkpoint });
    }
}

/// A task in its state after a decision.
struct Running {
    decider: Decider,
    at: Key,
    /// Whether all objects that it saw were recorded.
    sure: bool,
}

/// A decision that differs, made from a state of which not all objects were recorded. It is a
/// difference only if the missing objects were at rest.
struct Doubt {
    state: Key,
    difference: Difference,
}

type Statuses<'s> = [Option<&'s ArmStatus>; MAX_ARMS];

impl<'a> TaskCheck<'a> {
    pub(super) fn new(policies: &'a Policies, cell: &'a Cell, policy: &'a str) -> Self {
        Self {
            policies,
            cell,
            policy,
            waiting: VecDeque::new(),
            running: None,
            last: None,
            state: Box::new(WorldState::zeroed()),
            history: Computed::default(),
            doubts: Vec::new(),
        }
    }

    /// Queues the next recorded decision.
    pub(super) fn offer(&mut self, decision: Box<Decision>) {
        self.waiting.push_back(decision);
    }

    /// Computes every decision whose inputs are recorded by now.
    pub(super) fn go_on(
        &mut self,
        inputs: &Inputs,
        records: &Checkpoints,
        report: &mut Report,
    ) -> Result<(), VerifyError> {
        while let Some(decision) = self.waiting.front() {
            let (generation, seq) = key(&decision.header);
            let before = (generation, seq.saturating_sub(1));
            if self.running.as_ref().is_none_or(|r| r.at != before) {
                self.running = self.begin(before, decision.policy.as_str(), records)?;
                report.stretches += u64::from(self.running.is_some());
            }
            // A restarted task sends the last decision of its predecessor again, which was
            // computed by another generation and is not an output of this one.
            if self.running.is_none() && seq == 1 && self.repeats(report) {
                self.waiting.pop_front();
                continue;
            }
            match self.step(inputs, report) {
                // As for commands: the input may follow, but not for ever.
                Step::Wait if self.waiting.len() < PATIENCE => break,
                Step::Wait | Step::Lost => {
                    self.running = None;
                    report.decisions.skipped += 1;
                }
                Step::Done => self.check_record((generation, seq), records, report)?,
            }
            self.waiting.pop_front();
        }
        self.judge_doubts(inputs, report);
        Ok(())
    }

    fn begin(
        &self,
        at: Key,
        policy: &str,
        records: &Checkpoints,
    ) -> Result<Option<Running>, VerifyError> {
        let Some(record) = records.after(Process::Task, at) else {
            return Ok(None);
        };
        // A restarted task may have another policy than the run started with. An unknown name
        // of a policy is reported as a difference and does not end the verification.
        let task = match self.policies.task(self.cell, policy) {
            Err(TaskError::UnknownPolicy { .. }) => self.policies.task(self.cell, self.policy),
            task => task,
        };
        let mut running = Running {
            decider: Decider::new(task?),
            at,
            sure: true,
        };
        running.restore(record)?;
        Ok(Some(running))
    }

    /// Whether the next decision is the last one of the previous task, which a restarted task
    /// sends a second time; it is compared with that.
    fn repeats(&mut self, report: &mut Report) -> bool {
        let (Some(head), Some(last)) = (self.waiting.front(), &mut self.last) else {
            return false;
        };
        if head.header.inputs != last.header.inputs {
            return false;
        }
        let found = compare("decision", &**head, last);
        report.decisions.add(found.is_some());
        report.differs(found);
        report.follow("decision", &**head, last);
        true
    }

    fn step(&mut self, inputs: &Inputs, report: &mut Report) -> Step {
        let (Some(running), Some(decision)) = (&mut self.running, self.waiting.front()) else {
            return Step::Lost;
        };
        let Some(state_key) = input(&decision.header, TopicId::WorldState) else {
            return Step::Lost;
        };
        let used = inputs.states.find(state_key).here().and_then(|seen| {
            let statuses = inputs_of(decision, inputs)?;
            Ok((seen, statuses))
        });
        let (seen, statuses) = match used {
            Ok(used) => used,
            Err(step) => return step,
        };
        // Unlike a controller the task reads objects; from a state with missing ones its memory
        // is unsure from then on, until a state record confirms it.
        seen.write(&mut self.state);
        running.sure &= seen.is_whole();
        let mut computed = running.decide(&self.state, &statuses, &mut self.history);
        running.at = key(&decision.header);
        report.compared_at(decision.header.tick);
        match compare("decision", &**decision, &mut computed) {
            Some(difference) if !running.sure => self.doubts.push(Doubt {
                state: state_key,
                difference,
            }),
            found => {
                report.decisions.add(found.is_some());
                report.differs(found);
                report.follow("decision", &**decision, &computed);
            }
        }
        self.last = Some(computed);
        Step::Done
    }

    /// Compares the memory of the task with its recorded checkpoint, if there is one for this
    /// decision, and continues from the recorded one where they differ.
    fn check_record(
        &mut self,
        at: Key,
        records: &Checkpoints,
        report: &mut Report,
    ) -> Result<(), VerifyError> {
        let Some(running) = &mut self.running else {
            return Ok(());
        };
        let Some(record) = records.after(Process::Task, at) else {
            // Memory that rests on objects of unknown pose would make all later decisions
            // doubtful; start again at the next record.
            if !running.sure {
                self.running = None;
            }
            return Ok(());
        };
        let computed = running.decider.task.checkpoint();
        let same = computed == record.bytes;
        // An unsure memory may differ for want of objects alone: it is replaced, not counted.
        if running.sure {
            report.records.add(!same);
        }
        if running.sure && !same {
            let (field, recorded, computed) = first_byte(&record.bytes, &computed);
            report.differs(Some(Difference {
                message: "record of task".to_owned(),
                generation: at.0,
                seq: at.1,
                tick: record.header.tick,
                field,
                recorded,
                computed,
            }));
        }
        if !same {
            running.restore(record)?;
        }
        running.sure = true;
        Ok(())
    }

    // Judged late: whether objects were at rest is known at the next state that has them all.
    fn judge_doubts(&mut self, inputs: &Inputs, report: &mut Report) {
        self.doubts.retain(|doubt| {
            let Some(rested) = inputs.states.rests_around(doubt.state) else {
                return true;
            };
            if rested {
                report.decisions.add(true);
                report.differs(Some(doubt.difference.clone()));
            } else {
                report.decisions.skipped += 1;
            }
            false
        });
    }
}

impl Running {
    fn restore(&mut self, record: &Checkpoint) -> Result<(), VerifyError> {
        let state = input(&record.header, TopicId::WorldState);
        let decided = state.map(|(generation, _)| (generation, record.header.tick));
        Ok(self.decider.restore(&record.bytes, decided)?)
    }

    fn decide(
        &mut self,
        state: &WorldState,
        statuses: &Statuses<'_>,
        history: &mut Computed,
    ) -> Decision {
        let mut decision = Decision::zeroed();
        let _begun = self.decider.begin(state, history);
        self.decider
            .decide(state, statuses, &mut decision, &mut Vec::new());
        decision
    }
}

/// The statuses from which `decision` was made.
fn inputs_of<'i>(decision: &Decision, inputs: &'i Inputs) -> Result<Statuses<'i>, Step> {
    let mut statuses = [None; MAX_ARMS];
    for (arm, (slot, window)) in (0_u8..).zip(statuses.iter_mut().zip(&inputs.statuses)) {
        let Some(named) = input(&decision.header, TopicId::ArmStatus(arm)) else {
            continue;
        };
        *slot = Some(&**window.find(named).here()?);
    }
    Ok(statuses)
}
