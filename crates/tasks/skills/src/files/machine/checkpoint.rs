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
    /// Guards and events, by their names.
    guards: Vec<(String, ByteBuf)>,
    events: Vec<(String, ByteBuf)>,
    board: ByteBuf,
    /// Names of events that fired and have held since.
    fired: Vec<String>,
}

impl MachineJob {
    /// State of the machine and of the trees that it runs, encoded.
    pub(in crate::files) fn save(&self) -> Vec<u8> {
        let mut board = Vec::new();
        self.parts.shared.save(&mut board);
        let guards = self.parts.conditions.iter();
        let events = self.events.iter();
        checkpoint::to_bytes(&Record {
            machine: ByteBuf::from(self.run.save()),
            sequences: parts::save(&self.parts.sequences),
            guards: parts::save_named(guards.map(|(name, tree)| (name.as_str(), tree))),
            events: parts::save_named(events.map(|event| (event.name.as_str(), &event.tree))),
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
        let guards = self.parts.conditions.iter_mut();
        let guards = guards.map(|(name, tree)| (name.as_str(), tree));
        parts::restore_named(guards, &record.guards)?;
        let events = self.events.iter_mut();
        let events = events.map(|event| (event.name.as_str(), &mut event.tree));
        parts::restore_named(events, &record.events)?;
        parts::restore(&mut self.parts.sequences, &record.sequences)
    }
}
