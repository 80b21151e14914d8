//! The checkpoints of the task, each with the decision it led to, in a two-slot
//! file that outlives the process.

use std::path::{Path, PathBuf};

use cell_rt::SlotFile;
use ipc_types::{Decision, Wire};
use serde::{Deserialize, Serialize};

use robocell_task::checkpoint::{self, MAX_BYTES};

/// Name of the file in the run directory.
const FILE: &str = "task.slots";

/// The file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}; check that the run directory belongs to you and has room", path = path.display())]
pub struct SlotsError {
    path: PathBuf,
    source: std::io::Error,
}

/// What was written for one tick.
pub struct Saved {
    /// The tick.
    pub tick: u64,
    /// The decision that was made, to be published again if nobody heard it.
    pub decision: Decision,
    /// The task's checkpoint.
    pub checkpoint: Vec<u8>,
}

/// The two-slot file of the task.
pub struct Slots {
    file: SlotFile,
    run: u64,
    seq: u64,
    buffer: Vec<u8>,
}

#[derive(Serialize, Deserialize)]
struct Head {
    run: u64,
    physics_generation: u32,
    tick: u64,
}

impl Slots {
    /// Opens the file in `run_dir`, or begins it.
    ///
    /// # Errors
    ///
    /// When it cannot be mapped.
    pub fn open(run_dir: &Path, run: u64) -> Result<Self, SlotsError> {
        let path = run_dir.join(FILE);
        let capacity = HEAD_BYTES + size_of::<Decision>() + usize::try_from(MAX_BYTES).unwrap_or(0);
        let file = SlotFile::open(&path, capacity).map_err(|source| SlotsError { path, source })?;
        let seq = file.newest().map_or(0, |(seq, _)| seq);
        Ok(Self {
            file,
            run,
            seq,
            buffer: Vec::with_capacity(capacity),
        })
    }

    /// The newest entry of this run and this start of physics.
    pub fn newest(&self, physics_generation: u32) -> Option<Saved> {
        let (_, bytes) = self.file.newest()?;
        let (head, rest) = bytes.split_at_checked(HEAD_BYTES)?;
        let head: Head = checkpoint::from_bytes(head).ok()?;
        if head.run != self.run || head.physics_generation != physics_generation {
            return None;
        }
        let (decision, checkpoint) = rest.split_at_checked(size_of::<Decision>())?;
        Some(Saved {
            tick: head.tick,
            decision: Decision::from_bytes(decision)?,
            checkpoint: checkpoint.to_vec(),
        })
    }

    /// Writes an entry; `false` when it is too long.
    pub fn write(
        &mut self,
        physics_generation: u32,
        tick: u64,
        decision: &Decision,
        checkpoint: &[u8],
    ) -> bool {
        self.seq += 1;
        self.buffer.clear();
        let head = Head {
            run: self.run,
            physics_generation,
            tick,
        };
        self.buffer.extend(checkpoint::to_bytes(&head));
        self.buffer.extend(decision.as_bytes());
        self.buffer.extend(checkpoint);
        self.file.write(self.seq, &self.buffer)
    }
}

/// Bytes of a [`Head`] with fixed-size numbers.
const HEAD_BYTES: usize = 8 + 4 + 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_run_and_another_physics_are_not_remembered() {
        let dir = std::env::temp_dir().join(format!("robocell-slots-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let mut slots = Slots::open(&dir, 7).unwrap();
        assert!(slots.newest(1).is_none());
        let mut decision = Decision::zeroed();
        decision.drops = 3;
        for tick in [10, 20] {
            assert!(slots.write(1, tick, &decision, b"checkpoint"));
        }
        drop(slots);
        let slots = Slots::open(&dir, 7).unwrap();
        let saved = slots.newest(1).unwrap();
        assert_eq!(
            (saved.tick, saved.decision.drops, &saved.checkpoint[..]),
            (20, 3, &b"checkpoint"[..])
        );
        assert!(slots.newest(2).is_none());
        assert!(Slots::open(&dir, 8).unwrap().newest(1).is_none());
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
