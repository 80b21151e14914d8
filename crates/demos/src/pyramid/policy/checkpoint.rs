//! What a task of the pyramid writes down to go on later.

use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::Json;
use crate::pyramid::phases::Shown;
use robocell_task::checkpoint;

/// Version of the layout of [`Record`].
const VERSION: u32 = 1;

/// What the policy remembers beside trees and boards.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// Key of the newest goal.
    pub(super) last_key: u64,
    /// By arm: its tree succeeded and is not ticked again.
    pub(super) finished: Vec<bool>,
    pub(super) shown: Shown,
}

#[derive(Serialize, Deserialize)]
struct Record {
    version: u32,
    /// Tells one list of nodes from another.
    shape: u64,
    trees: Vec<ByteBuf>,
    boards: Vec<ByteBuf>,
    memory: Memory,
}

impl Memory {
    pub(super) fn new(arms: usize) -> Self {
        Self {
            last_key: 0,
            finished: vec![false; arms],
            shown: Shown::new(arms),
        }
    }

    pub(super) fn is_finished(&self, arm: usize) -> bool {
        self.finished.get(arm).copied().unwrap_or(false)
    }

    pub(super) fn finish(&mut self, arm: usize) {
        if let Some(finished) = self.finished.get_mut(arm) {
            *finished = true;
        }
    }
}

impl Json {
    /// Trees, boards and memory as plain bytes.
    pub(super) fn to_checkpoint(&self) -> Vec<u8> {
        let mut record = Record {
            version: VERSION,
            shape: self.shape(),
            trees: Vec::new(),
            boards: Vec::new(),
            memory: self.memory.clone(),
        };
        for robot in &self.robots {
            let mut bytes = Vec::new();
            robot.tree.save(&mut bytes);
            record.trees.push(ByteBuf::from(bytes));
        }
        for (_, board) in &self.boards {
            let mut bytes = Vec::new();
            board.save(&mut bytes);
            record.boards.push(ByteBuf::from(bytes));
        }
        checkpoint::to_bytes(&record)
    }

    /// Takes back what [`Self::to_checkpoint`] gave; half of it, perhaps, where that
    /// is an error.
    pub(super) fn take_checkpoint(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = checkpoint::from_bytes(bytes)?;
        let fits = record.version == VERSION
            && record.trees.len() == self.robots.len()
            && record.boards.len() == self.boards.len()
            && record.memory.finished.len() == self.robots.len();
        if !fits {
            return Err(foreign("another version, or another cell"));
        }
        self.lost = 0;
        for ((_, board), bytes) in self.boards.iter_mut().zip(&record.boards) {
            self.lost += board.restore(bytes).map_err(foreign)?.lost;
        }
        for (robot, bytes) in self.robots.iter_mut().zip(&record.trees) {
            self.lost += robot.tree.restore(bytes).map_err(foreign)?.lost;
        }
        self.memory = record.memory;
        if record.shape != self.shape() {
            // The nodes have other numbers now.
            let tips = self.robots.iter().map(|r| r.tree.tip());
            self.memory.shown.begin_at(tips.collect());
        }
        Ok(())
    }

    /// A number for the ids of all nodes, FNV-1a.
    fn shape(&self) -> u64 {
        let nodes = self.robots.iter().flat_map(|r| &r.graph.nodes);
        let bytes = nodes.flat_map(|n| n.id.bytes().chain([0]));
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}

#[allow(
    clippy::unnecessary_box_returns,
    reason = "the error of bincode is a box"
)]
fn foreign(why: impl std::fmt::Display) -> bincode::Error {
    let text = format!("not a checkpoint of these trees: {why}");
    serde::de::Error::custom(text)
}
