//! The arm of a client: its inputs are states and messages of the client.

use cell_model::{ArmSpec, Cell};
use ipc_types::client::ClientEvent;
use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Wire, WorldState};

use super::super::VerifyError;
use super::super::inputs::{Inputs, input};
use super::super::message_window::Step;
use super::super::states::SeenState;
use super::{CommandInputs, Computed};
use crate::gateway::{ClientArm, Gateways};

/// The controller of the arm in the state after a command.
pub(super) struct Client {
    controller: Box<dyn ClientArm>,
    arm: u8,
}

impl Client {
    /// That of the arm `spec` with number `arm`, as of a checkpoint.
    pub(super) fn begin(
        gateways: &Gateways,
        (cell, spec): (&Cell, &ArmSpec),
        arm: u8,
        checkpoint: &[u8],
    ) -> Result<Self, VerifyError> {
        for gateway in gateways {
            let made = gateway.client_arm(cell, arm, checkpoint);
            if let Some(controller) = made.map_err(VerifyError::Gateway)? {
                return Ok(Self { controller, arm });
            }
        }
        Err(VerifyError::NoGateway(spec.name.clone()))
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
            self.controller.take(received, seen.map(|_| &*state));
        }
        used.state.write_arms(state);
        let (mut computed, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
        if !self.controller.update(state, &mut computed, &mut status) {
            return Err(Step::Lost);
        }
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
        let taken = self.controller.input().filter(|(of, _)| *of == generation);
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
        self.controller.save(bytes).map_err(VerifyError::Gateway)
    }
}
