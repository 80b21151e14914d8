//! All of a cell in one process as bytes: the world, the memory of each controller and of the
//! task, and the messages in flight.
//!
//! Two things can go wrong. A part that is not saved makes the continuation differ from the
//! original run by one bit, which only a comparison of state hashes shows. And a restore that
//! fails half way leaves a world of one instant with controllers of another. So:
//!
//! - Messages of the present tick are part of the snapshot, because the next step and the next
//!   decision read them.
//! - `restore` builds every part aside first; the plant, which is changed in place, is the last
//!   step that may fail, and it is unchanged if it does.
//! - A field added to [`OneProcess`] that influences a tick must be added to `Saved`, with a
//!   new `VERSION`.

use cell_model::stop::DECISION_AGE_FIFO_TICKS;
use cell_run::message::Message;
use controller_proc::cycle::Cycle;
use ipc_types::tap::KEYFRAME_BYTES;
use ipc_types::{ArmCommand, ArmStatus, Decision, Wire};
use robocell_task::starts::Decider;
use serde::{Deserialize, Serialize};

use crate::{OneProcess, SimError};

/// Version of the layout; another one is refused: bincode has no field names, so another layout
/// would be read as wrong values, not as an error.
const VERSION: u32 = 2;

/// Reason for which a snapshot was refused.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// Damaged, or of another layout.
    #[error("the snapshot cannot be read: {0}")]
    Unreadable(#[from] bincode::Error),
    /// Written by another version.
    #[error("the snapshot has layout version {found}, this build reads {VERSION}")]
    Version {
        /// Version in the snapshot.
        found: u32,
    },
    /// Of a cell with another number of arms.
    #[error("the snapshot has {found} arms, this cell has {expected}")]
    OtherArms {
        /// Arms in the snapshot.
        found: usize,
        /// Arms of the cell.
        expected: usize,
    },
    /// The part of a controller.
    #[error(transparent)]
    Controller(#[from] controller_proc::checkpoint::CheckpointError),
}

#[derive(Serialize, Deserialize)]
struct Saved {
    version: u32,
    #[serde(with = "serde_bytes")]
    plant: Vec<u8>,
    #[serde(with = "serde_bytes")]
    task: Vec<u8>,
    #[serde(with = "serde_bytes")]
    decision: Vec<u8>,
    decided: bool,
    task_restarts: u32,
    arms: Vec<SavedArm>,
}

#[derive(Serialize, Deserialize)]
struct SavedArm {
    #[serde(with = "serde_bytes")]
    cycle: Vec<u8>,
    #[serde(with = "serde_bytes")]
    command: Vec<u8>,
    #[serde(with = "serde_bytes")]
    status: Vec<u8>,
}

impl OneProcess {
    /// The present state of everything in the cell, for [`OneProcess::restore`].
    ///
    /// # Errors
    /// None that the state of a cell causes.
    pub fn snapshot(&mut self) -> Result<Vec<u8>, SimError> {
        // As large as the record of a controller in a recording: `save` refuses a longer one.
        let mut room = vec![0; KEYFRAME_BYTES];
        let mut arms = Vec::with_capacity(self.cycles.len());
        let messages = self.commands.iter().zip(&self.statuses);
        for (cycle, (command, status)) in self.cycles.iter_mut().zip(messages) {
            let length = cycle
                .save(DECISION_AGE_FIFO_TICKS, &mut room)
                .map_err(SnapshotError::from)?;
            arms.push(SavedArm {
                cycle: room.get(..length).unwrap_or_default().to_vec(),
                command: command.as_bytes().to_vec(),
                status: status.as_bytes().to_vec(),
            });
        }
        let saved = Saved {
            version: VERSION,
            plant: self.plant.save(),
            task: self.decider.task.checkpoint(),
            decision: self.decision.as_bytes().to_vec(),
            decided: self.decided,
            task_restarts: self.task_restarts,
            arms,
        };
        Ok(bincode::serialize(&saved).map_err(SnapshotError::from)?)
    }

    /// Restores a snapshot of this cell, with this policy. The ticks that follow are computed
    /// as they were after the snapshot, bit for bit.
    ///
    /// # Errors
    /// Returns an error for damaged bytes, and for those of another cell or version. The cell
    /// is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SimError> {
        let (saved, messages) = self.read(bytes)?;
        let mut cycles = Vec::with_capacity(saved.arms.len());
        for (arm, of) in saved.arms.iter().enumerate() {
            let mut cycle = Cycle::with(&self.cell, arm, &self.controllers)?;
            cycle.restore(&of.cycle).map_err(SnapshotError::from)?;
            cycles.push(cycle);
        }
        let mut decider = Decider::new(self.policies.task(&self.cell, &self.policy)?);
        // `None`: the world is restored, too, so the decider has no gap to reconcile.
        decider.restore(&saved.task, None)?;
        // The last step that can fail, and it changes nothing if it does; what follows only
        // moves values, so the cell is never half restored.
        self.plant.restore(&saved.plant)?;
        self.cycles = cycles;
        self.decider = decider;
        self.decision = messages.decision;
        self.commands = messages.commands;
        self.statuses = messages.statuses;
        self.decided = saved.decided;
        self.task_restarts = saved.task_restarts;
        // Lines and messages after the snapshot belong to a future that is dropped.
        self.trace.clear();
        self.message = Message::default();
        self.plant.write_state(&mut self.state);
        Ok(())
    }

    fn read(&self, bytes: &[u8]) -> Result<(Saved, Messages), SnapshotError> {
        // The version is read alone first: the rest of another layout may not even decode.
        let found: u32 = bincode::deserialize(bytes.get(..4).unwrap_or_default())?;
        if found != VERSION {
            return Err(SnapshotError::Version { found });
        }
        let saved: Saved = bincode::deserialize(bytes)?;
        let (found, expected) = (saved.arms.len(), self.cycles.len());
        if found != expected {
            return Err(SnapshotError::OtherArms { found, expected });
        }
        let arms = saved.arms.iter();
        let messages = Messages {
            // Lengths are checked by `from_bytes`: bytes of another build are refused, not
            // reinterpreted.
            decision: message(&saved.decision)?,
            commands: arms
                .clone()
                .map(|arm| message(&arm.command))
                .collect::<Result<_, _>>()?,
            statuses: arms
                .map(|arm| message(&arm.status))
                .collect::<Result<_, _>>()?,
        };
        Ok((saved, messages))
    }
}

/// The messages of the present tick.
struct Messages {
    decision: Decision,
    commands: Vec<ArmCommand>,
    statuses: Vec<ArmStatus>,
}

fn message<T: Wire>(bytes: &[u8]) -> Result<T, SnapshotError> {
    let wrong = || serde::de::Error::custom("a message has another length");
    Ok(T::from_bytes(bytes).ok_or_else::<bincode::Error, _>(wrong)?)
}
