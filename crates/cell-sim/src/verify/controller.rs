//! The controller of one arm, computed again.

use std::collections::VecDeque;

use cell_model::Cell;
use controller_proc::Controllers;
use controller_proc::cycle::Cycle;
use controller_proc::planning::Planner;
use ipc_types::tap::KEYFRAME_BYTES;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmCommand, ArmStatus, Decision, Wire, WorldState};

use super::VerifyError;
use super::difference::{Difference, first_byte};
use super::inputs::{Checkpoints, Inputs, input};
use super::report::{Report, compare};
use super::shelf::{Found, Key, PATIENCE, Step, key};
use super::states::SeenState;

/// Compares the commands of one arm with what its controller computes.
pub(super) struct ArmCheck<'a> {
    cell: &'a Cell,
    controllers: &'a Controllers,
    arm: u8,
    /// Made when the first plan was answered.
    planner: Option<Planner>,
    waiting: VecDeque<Box<ArmCommand>>,
    running: Option<Running>,
    state: Box<WorldState>,
    bytes: Vec<u8>,
}

/// A controller as it was after a command.
struct Running {
    cycle: Cycle,
    decision_limit_ticks: u64,
    at: Key,
}

impl<'a> ArmCheck<'a> {
    pub(super) fn new(cell: &'a Cell, arm: u8, controllers: &'a Controllers) -> Self {
        Self {
            cell,
            controllers,
            arm,
            planner: None,
            waiting: VecDeque::new(),
            running: None,
            state: Box::new(WorldState::zeroed()),
            bytes: vec![0; KEYFRAME_BYTES],
        }
    }

    /// The next command of this arm.
    pub(super) fn offer(&mut self, command: Box<ArmCommand>) {
        self.waiting.push_back(command);
    }

    /// Computes what can be computed by now.
    pub(super) fn go_on(
        &mut self,
        inputs: &Inputs,
        records: &Checkpoints,
        report: &mut Report,
    ) -> Result<(), VerifyError> {
        while let Some(command) = self.waiting.front() {
            let (generation, seq) = key(&command.header);
            let before = (generation, seq.saturating_sub(1));
            if self.running.as_ref().is_none_or(|r| r.at != before) {
                self.running = self.begin(before, records)?;
                report.stretches += u64::from(self.running.is_some());
            }
            match self.step(inputs, report)? {
                Step::Wait if self.waiting.len() < PATIENCE => return Ok(()),
                Step::Wait | Step::Lost => {
                    self.running = None;
                    report.commands.skipped += 1;
                }
                Step::Done => self.check_record((generation, seq), records, report)?,
            }
            self.waiting.pop_front();
        }
        Ok(())
    }

    fn process(&self) -> Process {
        Process::Controller(self.arm)
    }

    fn begin(&self, at: Key, records: &Checkpoints) -> Result<Option<Running>, VerifyError> {
        let Some(record) = records.after(self.process(), at) else {
            return Ok(None);
        };
        let mut cycle = Cycle::with(self.cell, usize::from(self.arm), self.controllers)?;
        let decision_limit_ticks = cycle.restore(&record.bytes)?;
        Ok(Some(Running {
            cycle,
            decision_limit_ticks,
            at,
        }))
    }

    fn step(&mut self, inputs: &Inputs, report: &mut Report) -> Result<Step, VerifyError> {
        let (Some(running), Some(command)) = (&mut self.running, self.waiting.front()) else {
            return Ok(Step::Lost);
        };
        let heard = match heard(self.arm, command, running.cycle.latched(), inputs) {
            Ok(heard) => heard,
            Err(step) => return Ok(step),
        };
        if let Some(request) = running.cycle.plan_request() {
            // When the answer came is in the status alone.
            let Some(status) = heard.status else {
                return Ok(Step::Lost);
            };
            if status.answered_plan == request.id {
                let planner = match &mut self.planner {
                    Some(planner) => planner,
                    none => none.insert(Planner::new(self.cell, usize::from(self.arm))?),
                };
                let answer = planner.answer(&request);
                running.cycle.answer_plan(&mut Some(answer));
            }
        }
        heard.state.write_arms(&mut self.state);
        let (mut computed, mut said) = (ArmCommand::zeroed(), ArmStatus::zeroed());
        running.cycle.update(
            &self.state,
            heard.decision,
            running.decision_limit_ticks,
            &mut computed,
            &mut said,
        );
        running.at = key(&command.header);
        report.compared_at(command.header.tick);
        let arm = self.arm;
        if let Some(status) = heard.status {
            let name = format!("status of arm {arm}");
            let found = compare(&name, status, &mut said);
            report.statuses.add(found.is_some());
            report.differs(found);
            report.follow(&name, status, &said);
        } else {
            report.statuses.skipped += 1;
        }
        let name = format!("command of arm {arm}");
        let found = compare(&name, &**command, &mut computed);
        report.commands.add(found.is_some());
        report.differs(found);
        report.follow(&name, &**command, &computed);
        Ok(Step::Done)
    }

    /// Compares what is remembered now with the checkpoint of it, if there is one,
    /// and continues from that where they differ.
    fn check_record(
        &mut self,
        at: Key,
        records: &Checkpoints,
        report: &mut Report,
    ) -> Result<(), VerifyError> {
        let (Some(record), Some(running)) = (records.after(self.process(), at), &mut self.running)
        else {
            return Ok(());
        };
        let limit = running.decision_limit_ticks;
        let length = running.cycle.save(limit, &mut self.bytes)?;
        let computed = self.bytes.get(..length).unwrap_or_default();
        report.records.add(computed != record.bytes);
        if computed == record.bytes {
            return Ok(());
        }
        let (field, recorded, computed) = first_byte(&record.bytes, computed);
        report.differs(Some(Difference {
            message: format!("record of {}", self.process().name()),
            generation: at.0,
            seq: at.1,
            tick: record.header.tick,
            field,
            recorded,
            computed,
        }));
        self.running = self.begin(at, records)?;
        Ok(())
    }
}

/// What a command was computed from, and the status that went with it.
struct Heard<'i> {
    state: &'i SeenState,
    /// Only one that is news to the controller.
    decision: Option<&'i Decision>,
    status: Option<&'i ArmStatus>,
}

fn heard<'i>(
    arm: u8,
    command: &ArmCommand,
    latched: Option<Key>,
    inputs: &'i Inputs,
) -> Result<Heard<'i>, Step> {
    let state = input(&command.header, TopicId::WorldState).ok_or(Step::Lost)?;
    let state = inputs.states.find(state).here()?;
    // What is latched already changes nothing when it is heard again.
    let named = input(&command.header, TopicId::Decision);
    let decision = match named.filter(|named| latched != Some(*named)) {
        Some(named) => Some(&**inputs.decisions.find(named).here()?),
        None => None,
    };
    let shelf = inputs.statuses.get(usize::from(arm)).ok_or(Step::Lost)?;
    let status = match shelf.find(key(&command.header)) {
        Found::NotYet => return Err(Step::Wait),
        // The two are sent together, and the same number of times.
        Found::Here(status) => {
            Some(&**status).filter(|status| status.header.inputs == command.header.inputs)
        }
        Found::Lost => None,
    };
    Ok(Heard {
        state,
        decision,
        status,
    })
}
