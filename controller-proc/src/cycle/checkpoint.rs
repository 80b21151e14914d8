//! The checkpoint of the cycle: each value that the next cycle depends on.

use super::Cycle;
use crate::checkpoint::{CheckpointError, Codec, VERSION};

impl Cycle {
    /// Writes the state of this cycle and the age limit of decisions into `out`; returns the
    /// bytes written. Allocates nothing. A restored cycle computes the same commands for the
    /// same states and decisions, to the bit.
    ///
    /// # Errors
    /// [`CheckpointError::Length`].
    pub fn save(
        &mut self,
        decision_limit_ticks: u64,
        out: &mut [u8],
    ) -> Result<usize, CheckpointError> {
        let mut limit = decision_limit_ticks;
        let mut codec = Codec::write(out);
        self.checkpoint(&mut codec, &mut limit)?;
        Ok(codec.len())
    }

    /// Restores what [`Cycle::save`] wrote; returns the age limit of decisions.
    ///
    /// # Errors
    /// [`CheckpointError`] for a checkpoint of another version, arm or robot, and for a
    /// damaged one; this cycle must then not be used any more.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<u64, CheckpointError> {
        let mut limit = 0;
        let mut codec = Codec::read(bytes);
        self.checkpoint(&mut codec, &mut limit)?;
        codec.end()?;
        Ok(limit)
    }

    fn checkpoint(
        &mut self,
        codec: &mut Codec<'_>,
        limit: &mut u64,
    ) -> Result<(), CheckpointError> {
        let mut version = VERSION;
        // The version is checked before anything is read, so that a layout of another build is
        // named as such and not as damage.
        codec.u32(&mut version)?;
        if version != VERSION {
            return Err(CheckpointError::Version { found: version });
        }
        codec.same("arm number", self.arm as u64)?;
        codec.same("joint count", self.joint_count as u64)?;
        codec.u64(limit)?;
        codec.option(
            "begun",
            &mut self.began_with,
            |codec, (generation, reset)| {
                codec.u32(generation)?;
                codec.u32(reset)
            },
        )?;
        codec.u64(&mut self.cycles)?;
        codec.u64(&mut self.clipped_cycles)?;
        codec.u64(&mut self.missed_cycles)?;
        codec.bool("giving way", &mut self.is_giving_way)?;
        codec.option("last tick", &mut self.last_tick, Codec::u64)?;
        self.latch.checkpoint(codec)?;
        self.last.checkpoint(codec)?;
        self.suction.checkpoint(codec)?;
        self.controllers.hand.checkpoint(codec)?;
        self.controllers.arm.checkpoint(codec)
    }
}
