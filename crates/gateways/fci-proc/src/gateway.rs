//! Verification of an arm with a client: its commands are computed a second time from recorded
//! messages.

use cell_model::{ArmSpec, Cell};
use cell_sim::gateway::{ClientArm, Gateway, GatewayError};
use ipc_types::{ArmCommand, ArmStatus, ClientInput, WorldState};

use crate::cycle::Cycle;

/// The Franka control interface, for the `main` of a task program.
#[derive(Clone, Copy, Debug)]
pub struct FrankaInterface;

impl Gateway for FrankaInterface {
    fn client_arm(
        &self,
        cell: &Cell,
        arm: u8,
        checkpoint: &[u8],
    ) -> Result<Option<Box<dyn ClientArm>>, GatewayError> {
        // Another gateway may have clients of its own.
        let spec = cell.arms.get(usize::from(arm));
        if !spec.is_some_and(ArmSpec::has_client) {
            return Ok(None);
        }
        let mut cycle = Cycle::new(cell, arm)?;
        cycle.restore(checkpoint)?;
        Ok(Some(Box::new(Verified(cycle))))
    }
}

/// A cycle without a client, so its replies are discarded.
struct Verified(Cycle);

impl ClientArm for Verified {
    fn input(&self) -> Option<(u32, u64)> {
        self.0.input()
    }

    fn take(&mut self, input: &ClientInput, state: Option<&WorldState>) {
        self.0.repeat(input.repeats);
        self.0.take(input, state);
        self.0.discard_replies();
    }

    fn update(
        &mut self,
        state: &WorldState,
        command: &mut ArmCommand,
        status: &mut ArmStatus,
    ) -> bool {
        let has_command = self.0.update(state, command, status);
        self.0.discard_replies();
        has_command
    }

    fn save(&self, bytes: &mut [u8]) -> Result<usize, GatewayError> {
        Ok(self.0.save(bytes)?)
    }
}
