//! The stacking job as a behaviour tree written in code: priorities from left to right,
//! recovery branches before the normal sequence.

pub mod leaves;
pub mod shape;

use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::tree::{Host, Tree};
use behavior::{Graph, NodeStatus};
use cell_model::cells::replace::Replace;
use ipc_types::Text;
use robocell_task::replaced::replace_leaves;
use robocell_task::tree_trace::TreeTrace;
use robocell_task::{AnyPolicy, Job, Observation, Output, checkpoint};
use serde::de::Error as _;
use serde::{Deserialize, Serialize};

use super::setup::StackSetup;
use super::transfer::Transfer;
use super::turn::Turn;

/// The host type of the tree.
pub struct StackHost;

/// The data that the leaves of the tree read and change during a tick.
pub struct StackWorld<'w> {
    /// The decision being made.
    pub turn: Turn<'w>,
    /// The cube that is being picked up or held.
    pub transfer: &'w mut Option<Transfer>,
}

impl Host for StackHost {
    type World<'w> = StackWorld<'w>;
}

/// See the module.
pub struct StackBt {
    setup: Arc<StackSetup>,
    tree: Tree<StackHost>,
    /// Checkpoint of the tree before its first tick.
    initial: Vec<u8>,
    transfer: Option<Transfer>,
    trace: TreeTrace,
}

#[derive(Serialize, Deserialize)]
struct Checkpoint {
    transfer: Option<Transfer>,
    #[serde(with = "serde_bytes")]
    tree: Vec<u8>,
}

impl StackBt {
    /// A policy before its first decision.
    pub fn new(setup: Arc<StackSetup>, tree: Tree<StackHost>) -> Self {
        let mut initial = Vec::new();
        tree.save(&mut initial);
        Self {
            trace: TreeTrace::new(&tree.graph()),
            setup,
            tree,
            initial,
            transfer: None,
        }
    }

    /// Resets all nodes. It cannot fail: the tree itself wrote these bytes.
    fn restart_tree(&mut self) {
        let _carried = self.tree.restore(&self.initial).is_ok();
    }
}

impl AnyPolicy for StackBt {
    fn replace(&mut self, rules: &[Replace]) -> Result<(), String> {
        replace_leaves([&mut self.tree], rules)?;
        // Replaced leaves change the layout of a checkpoint, so that of the start is written
        // again.
        self.initial.clear();
        self.tree.save(&mut self.initial);
        Ok(())
    }

    fn reset(&mut self) {
        self.restart_tree();
        self.transfer = None;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let Some(turn) = Turn::new(&self.setup, observation, job, out) else {
            return;
        };
        let transfer = &mut self.transfer;
        let mut world = StackWorld { turn, transfer };
        let now = Duration::from_millis(observation.time().ticks());
        self.tree.tick(now, &mut Board::new(), &mut world);
        self.trace.tick(&self.tree, 0, world.turn.world.out);
        world.turn.report();
    }

    fn phase(&self) -> Text<32> {
        let phase = self.transfer.map(|transfer| transfer.phase);
        phase.map_or(Text::EMPTY, |phase| Text::new(phase.name()))
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        vec![self.tree.graph()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.tree.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        let transfer = self.transfer;
        let mut tree = Vec::new();
        self.tree.save(&mut tree);
        checkpoint::to_bytes(&Checkpoint { transfer, tree })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.reset();
        let saved: Checkpoint = checkpoint::from_bytes(bytes)?;
        let cubes = self.setup.cubes.len();
        // A checkpoint of another cell may have more cubes; its index would be out of range.
        if saved
            .transfer
            .is_some_and(|transfer| transfer.cube >= cubes)
        {
            return Err(bincode::Error::custom(
                "a cube that the order does not have",
            ));
        }
        self.tree
            .restore(&saved.tree)
            .map_err(bincode::Error::custom)?;
        self.transfer = saved.transfer;
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let Some(mut turn) = Turn::new(&self.setup, observation, job, out) else {
            return;
        };
        if Transfer::reconcile(&mut self.transfer, &mut turn) {
            // Leaves that pick up succeed at once with a cube in the gripper, so starting over
            // is safe.
            self.restart_tree();
        }
    }
}
