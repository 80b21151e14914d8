//! Snapshots of the world, and its restoration from a snapshot or to the start.

use super::World;
use crate::error::WorldError;
use crate::state::snapshot;

impl World {
    /// The present state as bytes.
    pub fn snapshot(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.write_snapshot(&mut bytes);
        bytes
    }

    /// Appends the present state to `out`, as [`World::snapshot`] gives it.
    pub(crate) fn write_snapshot(&self, out: &mut Vec<u8>) {
        snapshot::encode(self.fingerprint, &self.memory, &self.engine, out);
    }

    /// Goes back to a snapshot of this cell, its tick included.
    ///
    /// # Errors
    /// [`WorldError::Snapshot`] for bytes of another cell, engine or program;
    /// the world is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), WorldError> {
        // Decoded as a whole before anything is assigned: damaged bytes leave the world
        // unchanged.
        let (memory, engine) = snapshot::decode(self.fingerprint, bytes)?;
        self.memory = memory;
        self.engine = engine;
        self.inputs.clear();
        // Joints and contacts are not part of the bytes; they are measured again.
        self.read_back();
        Ok(())
    }

    /// Puts the scene back to its start. The tick continues, so that time never runs backwards
    /// for any reader; requests and counts are kept.
    ///
    /// # Errors
    /// As [`World::restore`].
    pub fn reset(&mut self) -> Result<(), WorldError> {
        let (memory, engine) = snapshot::decode(self.fingerprint, &self.initial)?;
        self.memory.reset_to(memory);
        self.engine = engine;
        self.inputs.clear();
        self.read_back();
        Ok(())
    }
}
