//! Trees in files, one for each arm. Trees with a blackboard of the same name
//! share it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::Tree;
use behavior::{Graph, NodeStatus, Status, Str, Value};
use cell_model::Cell;
use ipc_types::Text;
use robocell_task::settings::behaviour_text;
use robocell_task::tree_trace::{KeyWatch, TreeTrace};
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError, TraceEvent, checkpoint};
use serde::de::Error as _;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::parts;
use crate::setup::Setup;
use crate::skill::Station;
use crate::world::World;

/// The tree of one arm.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeSource {
    /// File beside the cell file.
    pub file: String,
    /// Name of the blackboard it shares.
    pub board: String,
}

/// See the module.
pub(super) struct TreePolicy {
    setup: Arc<Setup>,
    arms: Vec<ArmTree>,
    boards: Vec<(String, Board, KeyWatch)>,
    initial: Vec<u8>,
    resumed: bool,
}

struct ArmTree {
    tree: Tree<Station>,
    graph: Graph,
    board: usize,
    trace: TreeTrace,
    /// Its answer in the decision before.
    status: Status,
    /// The node that failed last, which was reported.
    failed: Option<usize>,
}

#[derive(Serialize, Deserialize)]
struct Record {
    trees: Vec<ByteBuf>,
    boards: Vec<ByteBuf>,
    /// By arm: its tree had succeeded.
    done: Vec<bool>,
}

impl TreePolicy {
    /// One tree in code, for the first arm.
    pub(super) fn of_tree(setup: &Arc<Setup>, tree: Tree<Station>) -> Self {
        let mut policy = Self {
            setup: Arc::clone(setup),
            arms: Vec::new(),
            boards: Vec::new(),
            initial: Vec::new(),
            resumed: false,
        };
        let board = policy.board("shared");
        let graph = tree.graph();
        policy.add(tree, graph, board);
        policy.initial = policy.save();
        policy
    }

    fn add(&mut self, tree: Tree<Station>, graph: Graph, board: usize) {
        self.arms.push(ArmTree {
            trace: TreeTrace::new(&graph),
            tree,
            graph,
            board,
            status: Status::Running,
            failed: None,
        });
    }

    pub(super) fn new(
        cell: &Cell,
        setup: &Arc<Setup>,
        sources: &[TreeSource],
    ) -> Result<Self, SetupError> {
        let library = parts::library(setup, &cell.data, &[]);
        let mut policy = Self {
            setup: Arc::clone(setup),
            arms: Vec::new(),
            boards: Vec::new(),
            initial: Vec::new(),
            resumed: false,
        };
        let names: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
        for (name, source) in names.iter().zip(sources) {
            let board = policy.board(&source.board);
            let text = behaviour_text(cell, &source.file)?;
            let include = |name: &str| cell.read(name).ok().map(Cow::into_owned);
            let file = format!("cells/{}", source.file);
            let read = Source {
                file: &file,
                text: &text,
                include: &include,
            };
            let robot = Str::new(name).unwrap_or_default();
            let constants = BTreeMap::from([("robot".to_owned(), Value::Text(robot))]);
            let Some((_, shared, _)) = policy.boards.get_mut(board) else {
                continue;
            };
            let tree = descriptor::load(&read, &library, &constants, shared)
                .map_err(|errors| SetupError::in_file(errors.to_string()))?;
            let mut graph = tree.graph();
            if names.len() > 1 {
                (*name).clone_into(&mut graph.name);
            }
            policy.add(tree, graph, board);
        }
        policy.initial = policy.save();
        Ok(policy)
    }

    fn board(&mut self, name: &str) -> usize {
        let known = self.boards.iter().position(|(known, ..)| known == name);
        known.unwrap_or_else(|| {
            let board = (name.to_owned(), Board::new(), KeyWatch::default());
            self.boards.push(board);
            self.boards.len() - 1
        })
    }

    fn tick(&mut self, arm: usize, world: &mut World<'_>) {
        let Some(it) = self.arms.get_mut(arm) else {
            return;
        };
        let Some((_, shared, _)) = self.boards.get_mut(it.board) else {
            return;
        };
        let now = Duration::from_millis(world.now().ticks());
        let status = it.tree.tick(now, shared, world);
        it.trace.tick(&it.tree, arm, world.out);
        let name = &it.graph.name;
        let out = &mut *world.out;
        if status == Status::Success && it.status != Status::Success {
            out.event(TraceEvent::Done, format_args!("[done] {name}"));
            it.failed = None;
        }
        // One that fails again and again at the same node is reported once.
        let tip = it.tree.tip();
        if status == Status::Failure && it.failed != tip {
            let node = tip.and_then(|tip| it.graph.nodes.get(tip));
            let node = node.map_or("?", |node| node.name.as_str());
            out.log(format_args!(
                "[retry] {name}: '{node}' failed; the tree starts again"
            ));
            it.failed = tip;
        }
        it.status = status;
    }

    fn is_done(&self) -> bool {
        self.arms.iter().all(|arm| arm.status == Status::Success)
    }
}

impl TreePolicy {
    /// Takes a checkpoint; a part of it, perhaps, where that is an error.
    fn take(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = checkpoint::from_bytes(bytes)?;
        if record.trees.len() != self.arms.len() || record.boards.len() != self.boards.len() {
            return Err(bincode::Error::custom("not a checkpoint of these trees"));
        }
        for ((_, board, _), bytes) in self.boards.iter_mut().zip(&record.boards) {
            board.restore(bytes).map_err(bincode::Error::custom)?;
        }
        for (arm, bytes) in self.arms.iter_mut().zip(&record.trees) {
            arm.tree.restore(bytes).map_err(bincode::Error::custom)?;
        }
        for (arm, done) in self.arms.iter_mut().zip(record.done) {
            arm.status = if done {
                Status::Success
            } else {
                Status::Running
            };
        }
        Ok(())
    }
}

impl AnyPolicy for TreePolicy {
    fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It was written by this very policy.
        let _taken = self.take(&initial).is_ok();
        self.initial = initial;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let resumed = std::mem::take(&mut self.resumed);
        for arm in 0..self.arms.len() {
            let mut world = World::new(&setup, observation, job, out, arm);
            world.resumed = resumed;
            self.tick(arm, &mut world);
            world.finish();
        }
        for (name, board, watch) in &mut self.boards {
            watch.changes(board, name, 0, out);
        }
        World::new(&setup, observation, job, out, 0).report(self.is_done());
        out.phase = self.phase();
    }

    /// Name of the node that gave the answer of the first tree at work.
    fn phase(&self) -> Text<32> {
        let at_work = self.arms.iter().find(|arm| arm.status != Status::Success);
        let arm = at_work.or(self.arms.first());
        let node = arm.and_then(|arm| arm.graph.nodes.get(arm.tree.tip()?));
        Text::new(node.map_or("", |node| node.name.as_str()))
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        self.arms.iter().map(|arm| arm.graph.clone()).collect()
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        if let Some(arm) = self.arms.get(graph) {
            arm.tree.statuses(out);
        }
    }

    fn save(&self) -> Vec<u8> {
        let tree = |arm: &ArmTree| {
            let mut bytes = Vec::new();
            arm.tree.save(&mut bytes);
            ByteBuf::from(bytes)
        };
        let board = |(_, board, _): &(String, Board, KeyWatch)| {
            let mut bytes = Vec::new();
            board.save(&mut bytes);
            ByteBuf::from(bytes)
        };
        let done = self.arms.iter().map(|arm| arm.status == Status::Success);
        checkpoint::to_bytes(&Record {
            trees: self.arms.iter().map(tree).collect(),
            boards: self.boards.iter().map(board).collect(),
            done: done.collect(),
        })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.take(bytes).inspect_err(|_| self.reset())
    }

    fn reconcile(&mut self, _observation: &Observation<'_>, _job: &mut Job, _out: &mut Output) {
        self.resumed = true;
    }
}
