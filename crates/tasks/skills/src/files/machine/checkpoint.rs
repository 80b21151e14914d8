//! The memory of a machine in a file, from decision to decision.

use robocell_task::checkpoint;
use serde::de::Error as _;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::{MachineJob, parts};

#[derive(Serialize, Deserialize)]
struct Record {
    machine: ByteBuf,
    sequences: Vec<ByteBuf>,
    board: ByteBuf,
    /// Names of events that fired and have held since.
    fired: Vec<String>,
}

impl MachineJob {
    /// State of the machine and of the trees that it runs, encoded.
    pub(in crate::files) fn save(&self) -> Vec<u8> {
        let mut board = Vec::new();
        self.parts.shared.save(&mut board);
        checkpoint::to_bytes(&Record {
            machine: ByteBuf::from(self.run.save()),
            sequences: parts::save(&self.parts.sequences),
            board: ByteBuf::from(board),
            fired: self
                .events
                .iter()
                .filter(|event| event.has_fired)
                .map(|event| event.name.clone())
                .collect(),
        })
    }

    /// Restores the bytes of [`Self::save`]; after an error the machine is in its first state.
    pub(in crate::files) fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.take(bytes).inspect_err(|_| self.reset())
    }

    /// Restores a checkpoint. After an error some parts may have been restored.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = checkpoint::from_bytes(bytes)?;
        self.run.restore(&record.machine)?;
        self.parts
            .shared
            .restore(&record.board)
            .map_err(bincode::Error::custom)?;
        for event in &mut self.events {
            event.has_fired = record.fired.contains(&event.name);
        }
        parts::restore(&mut self.parts.sequences, &record.sequences)
    }
}
