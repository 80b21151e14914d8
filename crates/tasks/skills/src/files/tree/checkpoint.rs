//! The memory of trees in files, from decision to decision.

use behavior::Status;
use robocell_task::checkpoint;
use serde::de::Error as _;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::{Shown, TreePolicy};
use crate::world::ArmMemory;

#[derive(Serialize, Deserialize)]
struct Record {
    trees: Vec<ByteBuf>,
    boards: Vec<ByteBuf>,
    /// By arm: whether its tree had succeeded.
    done: Vec<bool>,
    memories: Vec<ArmMemory>,
    shown: Shown,
}

impl TreePolicy {
    /// Trees, blackboards and memories, encoded.
    pub(super) fn to_checkpoint(&self) -> Vec<u8> {
        let bytes = |save: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = Vec::new();
            save(&mut bytes);
            ByteBuf::from(bytes)
        };
        let arms = self.arms.iter();
        let boards = self.boards.iter();
        checkpoint::to_bytes(&Record {
            trees: arms
                .clone()
                .map(|arm| bytes(&|to| arm.tree.save(to)))
                .collect(),
            boards: boards
                .map(|shared| bytes(&|to| shared.board.save(to)))
                .collect(),
            done: arms
                .clone()
                .map(|arm| arm.status == Status::Success)
                .collect(),
            memories: arms.map(|arm| arm.memory).collect(),
            shown: self.shown.clone(),
        })
    }

    /// Restores a checkpoint. After an error some parts may have been restored.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = checkpoint::from_bytes(bytes)?;
        let arms = self.arms.len();
        // Everything that can be checked is checked before the first part is changed.
        let by_arm = [record.trees.len(), record.done.len(), record.memories.len()];
        let objects = self.setup.objects.len();
        let sound = record.memories.iter().all(|m| m.is_sound(objects));
        if by_arm != [arms; 3] || record.boards.len() != self.boards.len() || !sound {
            return Err(bincode::Error::custom("not a checkpoint of these trees"));
        }
        self.lost = 0;
        // Boards before trees: nodes of an edited file look up their keys.
        for (shared, bytes) in self.boards.iter_mut().zip(&record.boards) {
            let carried = shared.board.restore(bytes);
            self.lost += carried.map_err(bincode::Error::custom)?.lost;
        }
        for (arm, bytes) in self.arms.iter_mut().zip(&record.trees) {
            let carried = arm.tree.restore(bytes);
            self.lost += carried.map_err(bincode::Error::custom)?.lost;
        }
        for (arm, done) in self.arms.iter_mut().zip(record.done) {
            arm.status = if done {
                Status::Success
            } else {
                Status::Running
            };
        }
        for (arm, memory) in self.arms.iter_mut().zip(record.memories) {
            arm.memory = memory;
        }
        // From the trees, not from the checkpoint: node numbers change with an edit.
        let tips = self.arms.iter().map(|arm| arm.tree.tip()).collect();
        self.shown.take(record.shown, tips);
        Ok(())
    }
}
