//! Interfaces between a cell and programs of others: what they add to a task program.
//!
//! A gateway is a package that uses public interfaces only. No package of the cell depends on
//! one; the `main` of a task program names those that it has.

use std::error::Error;
use std::fmt;
use std::sync::Arc;

use cell_model::Cell;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, WorldState};
use robocell_task::Policies;

/// The gateways of a task program.
pub type Gateways = Vec<Arc<dyn Gateway>>;

/// An error of a gateway, with its own text.
pub type GatewayError = Box<dyn Error + Send + Sync>;

/// An interface to programs of others.
pub trait Gateway: fmt::Debug + Send + Sync {
    /// `policies`, with those that this gateway reaches.
    fn policies(&self, policies: Policies) -> Policies {
        policies
    }

    /// The controller of an arm of `cell` whose commands come from a client of this gateway, in
    /// the state of `checkpoint`; `None` for an arm of another gateway. `replay --verify` calls it;
    /// a running cell has a process for the arm.
    ///
    /// # Errors
    /// If the arm has no such interface, and for a checkpoint that is damaged or of another
    /// version.
    fn client_arm(
        &self,
        _cell: &Cell,
        _arm: u8,
        _checkpoint: &[u8],
    ) -> Result<Option<Box<dyn ClientArm>>, GatewayError> {
        Ok(None)
    }
}

/// The controller of an arm with a client. Its inputs are states and recorded messages of the
/// client, so a verification computes its commands a second time.
pub trait ClientArm {
    /// Generation and number of the last message that was taken.
    fn input(&self) -> Option<(u32, u64)>;

    /// Takes the next message of the client; `state` is that at which it arrived, for messages that
    /// depend on it.
    fn take(&mut self, input: &ClientInput, state: Option<&WorldState>);

    /// Writes the command of a cycle and the status beside it; false if there is none.
    fn update(
        &mut self,
        state: &WorldState,
        command: &mut ArmCommand,
        status: &mut ArmStatus,
    ) -> bool;

    /// Writes a checkpoint; its length.
    ///
    /// # Errors
    /// If it is longer than `bytes`.
    fn save(&self, bytes: &mut [u8]) -> Result<usize, GatewayError>;
}
