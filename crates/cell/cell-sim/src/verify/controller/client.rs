//! The control interface of a client: its inputs are states and what the client sent.

use cell_model::Cell;
use fci_proc::cycle::Cycle;
use ipc_types::client::ClientEvent;
use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Wire, WorldState};

use super::super::VerifyError;
use super::super::inputs::{Inputs, input};
use super::super::message_window::Step;
use super::super::states::SeenState;
use super::{CommandInputs, Computed};

/// The interface in its state after a command.
pub(super) struct Client {
    cycle: Cycle,
    arm: u8,
}

impl Client {
    /// That of `arm`, as of a checkpoint.
    pub(super) fn begin(cell: &Cell, arm: u8, checkpoint: &[u8]) -> Result<Self, VerifyError> {
        let mut cycle = Cycle::new(cell, arm)?;
        cycle.restore(checkpoint)?;
        Ok(Self { cycle, arm })
    }

    /// Computes a command and the status beside it.
    pub(super) fn compute(
        &mut self,
        command: &ArmCommand,
        (used, inputs): (&CommandInputs<'_>, &Inputs),
        state: &mut WorldState,
    ) -> Result<Computed, Step> {
        // All of them first: a step that has to wait for one is repeated.
        for (received, seen) in self.received(command, inputs)? {
            if let Some(seen) = seen {
                seen.write_arms(state);
            }
            self.cycle.repeat(received.repeats);
            self.cycle.take(received, seen.map(|_| &*state));
            self.cycle.discard_replies();
        }
        used.state.write_arms(state);
        let (mut computed, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
        if !self.cycle.update(state, &mut computed, &mut status) {
            return Err(Step::Lost);
        }
        self.cycle.discard_replies();
        Ok((computed, status))
    }

    /// The inputs since the last command, each with the state at which it was taken where that
    /// counts.
    fn received<'i>(
        &self,
        command: &ArmCommand,
        inputs: &'i Inputs,
    ) -> Result<Vec<(&'i ClientInput, Option<&'i SeenState>)>, Step> {
        let Some((generation, last)) = input(&command.header, TopicId::ClientTap(self.arm)) else {
            return Ok(Vec::new());
        };
        let taken = self.cycle.input().filter(|(of, _)| *of == generation);
        let first = taken.map_or(1, |(_, seq)| seq.saturating_add(1));
        let window = inputs.clients.get(usize::from(self.arm));
        let window = window.ok_or(Step::Lost)?;
        let mut received = Vec::new();
        for seq in first..=last {
            let one = &**window.find((generation, seq)).here()?;
            let seen = if one.event == ClientEvent::HandRequest.code() {
                let state = input(&one.header, TopicId::WorldState).ok_or(Step::Lost)?;
                Some(inputs.states.find(state).here()?)
            } else {
                None
            };
            received.push((one, seen));
        }
        Ok(received)
    }

    /// Writes its checkpoint; its length.
    pub(super) fn save(&self, bytes: &mut [u8]) -> Result<usize, VerifyError> {
        Ok(self.cycle.save(bytes)?)
    }
}
