//! Verification of the controller of one arm: its commands are computed a second time.

mod client;
mod own;

use std::collections::VecDeque;

use cell_model::Cell;
use ipc_types::tap::KEYFRAME_BYTES;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmCommand, ArmStatus, Wire, WorldState};

use super::VerifyError;
use super::difference::{Difference, first_byte};
use super::inputs::{Checkpoint, Checkpoints, Inputs, input};
use super::message_window::{Found, Key, PATIENCE, Step, key};
use super::report::{Report, compare};
use super::states::SeenState;
use crate::Program;

use client::Client;
use own::Own;

/// Compares the commands of one arm with what its controller computes.
pub(super) struct ArmCheck<'a> {
    program: &'a Program,
    cell: &'a Cell,
    arm: u8,
    waiting: VecDeque<Box<ArmCommand>>,
    running: Option<Running>,
    state: Box<WorldState>,
    bytes: Vec<u8>,
}

/// A controller in its state after a command.
struct Running {
    controller: Controller,
    at: Key,
}

/// What computes the commands of an arm.
enum Controller {
    /// A controller of this project.
    Own(Box<Own>),
    /// That of a gateway, for a client.
    Client(Box<Client>),
}

impl Controller {
    /// That of an arm, as of a checkpoint.
    fn begin(check: &ArmCheck<'_>, record: &Checkpoint) -> Result<Self, VerifyError> {
        let arm = check.cell.arms.get(usize::from(check.arm));
        if let Some(spec) = arm.filter(|arm| arm.has_client()) {
            let gateways = &check.program.gateways;
            let client = Client::begin(gateways, (check.cell, spec), check.arm, &record.bytes)?;
            return Ok(Self::Client(Box::new(client)));
        }
        let own = Own::begin(
            (check.cell, &check.program.controllers),
            check.arm,
            &record.bytes,
        )?;
        Ok(Self::Own(Box::new(own)))
    }

    /// Computes a command and the status beside it.
    fn compute(
        &mut self,
        command: &ArmCommand,
        (used, inputs): (&CommandInputs<'_>, &Inputs),
        state: &mut WorldState,
    ) -> Result<Computed, Step> {
        match self {
            Self::Own(own) => own.compute(command, (used, inputs), state),
            Self::Client(client) => client.compute(command, (used, inputs), state),
        }
    }

    /// Writes its checkpoint; its length.
    fn save(&mut self, bytes: &mut [u8]) -> Result<usize, VerifyError> {
        match self {
            Self::Own(own) => own.save(bytes),
            Self::Client(client) => client.save(bytes),
        }
    }
}

/// A computed command, and the status beside it.
type Computed = (ArmCommand, ArmStatus);

impl<'a> ArmCheck<'a> {
    pub(super) fn new(program: &'a Program, cell: &'a Cell, arm: u8) -> Self {
        Self {
            program,
            cell,
            arm,
            waiting: VecDeque::new(),
            running: None,
            state: Box::new(WorldState::zeroed()),
            bytes: vec![0; KEYFRAME_BYTES],
        }
    }

    /// Queues the next recorded command of this arm.
    pub(super) fn offer(&mut self, command: Box<ArmCommand>) {
        self.waiting.push_back(command);
    }

    /// Computes every command whose inputs are recorded by now.
    pub(super) fn go_on(
        &mut self,
        inputs: &Inputs,
        records: &Checkpoints,
        report: &mut Report,
    ) -> Result<(), VerifyError> {
        while let Some(command) = self.waiting.front() {
            let (generation, seq) = key(&command.header);
            let before = (generation, seq.saturating_sub(1));
            // The controller computed so far continues only with the very next number of the
            // same generation. After a gap or a restart its memory is unknown, so a state
            // record is needed.
            if self.running.as_ref().is_none_or(|r| r.at != before) {
                self.running = self.begin(before, records)?;
                report.stretches += u64::from(self.running.is_some());
            }
            match self.step(inputs, report) {
                // Topics are recorded one after the other, so an input may follow later. Beyond
                // `PATIENCE` it will not, and waiting would hold every later command.
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
        let controller = Controller::begin(self, record)?;
        Ok(Some(Running { controller, at }))
    }

    fn step(&mut self, inputs: &Inputs, report: &mut Report) -> Step {
        let (Some(running), Some(command)) = (&mut self.running, self.waiting.front()) else {
            return Step::Lost;
        };
        let computed = inputs_of(self.arm, command, inputs).and_then(|used| {
            let of = (&used, inputs);
            let computed = running.controller.compute(command, of, &mut self.state)?;
            Ok((used, computed))
        });
        let (used, (mut computed, mut computed_status)) = match computed {
            Ok(computed) => computed,
            Err(step) => return step,
        };
        // From here on the controller is in the state after this command, compared or not.
        running.at = key(&command.header);
        report.compared_at(command.header.tick);
        let arm = self.arm;
        if let Some(status) = used.status {
            let name = format!("status of arm {arm}");
            let found = compare(&name, status, &mut computed_status);
            report.statuses.add(found.is_some());
            report.differs(found);
            report.follow(&name, status, &computed_status);
        } else {
            report.statuses.skipped += 1;
        }
        let name = format!("command of arm {arm}");
        let found = compare(&name, &**command, &mut computed);
        report.commands.add(found.is_some());
        report.differs(found);
        report.follow(&name, &**command, &computed);
        Step::Done
    }

    /// Compares the memory of the controller with its recorded checkpoint, if there is one for
    /// this command, and continues from the recorded one where they differ.
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
        let length = running.controller.save(&mut self.bytes)?;
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
        // Continuing from the computed memory would report one error again in every later
        // message.
        self.running = self.begin(at, records)?;
        Ok(())
    }
}

/// The state of a command, and the status that was sent with it.
struct CommandInputs<'i> {
    state: &'i SeenState,
    status: Option<&'i ArmStatus>,
}

fn inputs_of<'i>(
    arm: u8,
    command: &ArmCommand,
    inputs: &'i Inputs,
) -> Result<CommandInputs<'i>, Step> {
    let state = input(&command.header, TopicId::WorldState).ok_or(Step::Lost)?;
    let state = inputs.states.find(state).here()?;
    let window = inputs.statuses.get(usize::from(arm)).ok_or(Step::Lost)?;
    let status = match window.find(key(&command.header)) {
        Found::NotYet => return Err(Step::Wait),
        // Command and status of a cycle are sent together and have the same number. Unequal
        // inputs mean that one was not recorded, so the status is of another cycle.
        Found::Here(status) => {
            Some(&**status).filter(|status| status.header.inputs == command.header.inputs)
        }
        Found::Lost => None,
    };
    Ok(CommandInputs { state, status })
}
