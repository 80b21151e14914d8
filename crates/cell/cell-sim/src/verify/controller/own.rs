//! A controller of this project: its inputs are states and decisions.

use cell_model::Cell;
use controller_proc::Controllers;
use controller_proc::cycle::Cycle;
use controller_proc::planning::Planner;
use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, ArmStatus, Decision, Wire, WorldState};

use super::super::VerifyError;
use super::super::inputs::{Inputs, input};
use super::super::message_window::Step;
use super::{CommandInputs, Computed};

/// A controller in its state after a command.
pub(super) struct Own {
    cycle: Cycle,
    decision_limit_ticks: u64,
    planner: Planner,
}

impl Own {
    /// That of `arm`, as of a checkpoint.
    pub(super) fn begin(
        (cell, controllers): (&Cell, &Controllers),
        arm: u8,
        checkpoint: &[u8],
    ) -> Result<Self, VerifyError> {
        let arm = usize::from(arm);
        let mut cycle = Cycle::with(cell, arm, controllers)?;
        let decision_limit_ticks = cycle.restore(checkpoint)?;
        Ok(Self {
            cycle,
            decision_limit_ticks,
            planner: Planner::new(cell, arm)?,
        })
    }

    /// Computes a command and the status beside it.
    pub(super) fn compute(
        &mut self,
        command: &ArmCommand,
        (used, inputs): (&CommandInputs<'_>, &Inputs),
        state: &mut WorldState,
    ) -> Result<Computed, Step> {
        let decision = self.decision(command, inputs)?;
        if let Some(request) = self.cycle.plan_request() {
            // The status alone names the answered plan, hence the tick in which it was taken;
            // without the status the path of the arm from here on is unknown.
            let status = used.status.ok_or(Step::Lost)?;
            // The answer is computed again, not read: `Planner::answer` is pure (ADR 0021), so
            // the plan itself is verified, too.
            if status.answered_plan == request.id {
                let answer = self.planner.answer(&request);
                self.cycle.answer_plan(&mut Some(answer));
            }
        }
        // Objects are left out: a controller does not read them, and they are not in every
        // record.
        used.state.write_arms(state);
        let (mut computed, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
        let limit = self.decision_limit_ticks;
        self.cycle
            .update(state, decision, limit, &mut computed, &mut status);
        Ok((computed, status))
    }

    /// The decision that is new to the controller with this command.
    fn decision<'i>(
        &self,
        command: &ArmCommand,
        inputs: &'i Inputs,
    ) -> Result<Option<&'i Decision>, Step> {
        // A decision that the controller has latched already changes nothing, and may be older
        // than the first recorded one: it is not needed.
        let named = input(&command.header, TopicId::Decision);
        let latched = self.cycle.latched();
        match named.filter(|named| latched != Some(*named)) {
            Some(named) => Ok(Some(&**inputs.decisions.find(named).here()?)),
            None => Ok(None),
        }
    }

    /// Writes its checkpoint; its length.
    pub(super) fn save(&mut self, bytes: &mut [u8]) -> Result<usize, VerifyError> {
        Ok(self.cycle.save(self.decision_limit_ticks, bytes)?)
    }
}
