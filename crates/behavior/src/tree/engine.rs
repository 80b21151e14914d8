//! A tree, ready to run.

use std::time::Duration;

use super::error::TreeError;
use super::event::{Event, Events};
use super::flat::{Code, Counts, NONE};
use super::flatten::{Ready, flatten};
use super::leaf::{Cx, Halt, Host};
use super::run::Run;
use super::spec::Node;
use crate::board::Board;
use crate::finding::Finding;
use crate::graph::Graph;
use crate::status::{NodeStatus, ResetReason, Status};

/// A behaviour tree. After [`Tree::new`] nothing of it uses the heap but
/// [`Tree::graph`] and a [`Tree::save`] into a vector that is too small, and
/// the work of a tick is bounded by the number of its nodes.
pub struct Tree<H: Host> {
    pub(super) run: Run<H>,
    pub(super) local: Board,
    /// Time of the tick before.
    pub(super) last: Option<Duration>,
    /// For records: hash of each operation, in their order.
    pub(super) hashes: Vec<u64>,
    /// Hashes with their operations, sorted.
    pub(super) by_hash: Vec<(u64, usize)>,
    graph: Graph,
    pub(crate) noted: Vec<Finding>,
}

impl<H: Host> Tree<H> {
    /// What is probably not meant in the nodes of its file, as their types noted when they were
    /// made.
    pub fn noted(&self) -> &[Finding] {
        &self.noted
    }

    /// Makes `root` ready to run, with the tree's own blackboard.
    ///
    /// # Errors
    /// [`TreeError`] with all that is wrong: ids that are there twice, wrong
    /// numbers of children, more than [`super::MAX_NODES`], ...
    pub fn new(name: &str, root: Node<H>, local: Board) -> Result<Self, TreeError> {
        let Ready {
            flat,
            graph,
            hashes,
        } = flatten(name, root, &local)?;
        let mut by_hash: Vec<(u64, usize)> = hashes.iter().copied().zip(0..).collect();
        by_hash.sort_unstable();
        let events = Events::for_nodes(flat.ops.len());
        Ok(Self {
            run: Run {
                flat,
                changed: Vec::with_capacity(hashes.len()),
                events,
                halting: 0,
            },
            local,
            last: None,
            hashes,
            by_hash,
            graph,
            noted: Vec::new(),
        })
    }

    /// Ticks the tree at time `now`, which never goes back.
    ///
    /// While nodes halt, only they are called and the answer is `Running`.
    pub fn tick(&mut self, now: Duration, shared: &mut Board, world: &mut H::World<'_>) -> Status {
        self.with_cx(now, shared, world, |run, cx| {
            if run.halting > 0 && !run.drain(cx) {
                return Status::Running;
            }
            run.visit(0, cx)
        })
    }

    /// Stops everything. Once it says `Done` all is as if the tree never ran;
    /// until then it has to be called again, once a tick.
    pub fn reset(
        &mut self,
        reason: ResetReason,
        now: Duration,
        shared: &mut Board,
        world: &mut H::World<'_>,
    ) -> Halt {
        let through = self.with_cx(now, shared, world, |run, cx| {
            if run.halting > 0 {
                run.drain(cx);
            }
            for i in 0..run.flat.ops.len() {
                let status = run.flat.ops[i].status;
                if !matches!(status, NodeStatus::Invalid | NodeStatus::Halting) {
                    run.stop(i, reason, cx);
                }
            }
            run.halting == 0
        });
        if !through {
            return Halt::NotYet;
        }
        self.forget();
        self.local.reset();
        Halt::Done
    }

    /// The state of a tree that never ran, except for the board.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.run.halting = 0;
        let flat = &mut self.run.flat;
        flat.ops.iter_mut().for_each(super::flat::Op::forget);
        flat.leaves.iter_mut().for_each(|leaf| leaf.forget());
        flat.counts.fill(Counts::default());
        for timer in &mut flat.timers {
            timer.deadline = Duration::ZERO;
        }
    }

    fn with_cx<R>(
        &mut self,
        now: Duration,
        shared: &mut Board,
        world: &mut H::World<'_>,
        work: impl FnOnce(&mut Run<H>, &mut Cx<'_, '_, H>) -> R,
    ) -> R {
        self.run.events.clear();
        let delta = self
            .last
            .map_or(Duration::ZERO, |last| now.saturating_sub(last));
        self.last = Some(now);
        let mut cx = Cx {
            now,
            delta,
            node: 0,
            world,
            local: &mut self.local,
            shared,
        };
        let done = work(&mut self.run, &mut cx);
        self.run.tell();
        done
    }

    /// Status of the root.
    pub fn status(&self) -> NodeStatus {
        self.run
            .flat
            .ops
            .first()
            .map_or(NodeStatus::Invalid, |op| op.status)
    }

    /// Status of each node of the graph, in its order, modifiers included: a
    /// node whose check does not hold has failed.
    pub fn statuses(&self, out: &mut Vec<NodeStatus>) {
        out.clear();
        for op in &self.run.flat.ops {
            if op.outermost {
                out.push(op.status);
            } else if op.status == NodeStatus::Halting
                && let Some(last) = out.last_mut()
            {
                *last = NodeStatus::Halting;
            }
        }
    }

    /// The tree as a picture.
    pub fn graph(&self) -> Graph {
        self.graph.clone()
    }

    /// The deepest node that gave the tree's answer, `py_trees`' tip; `None`
    /// if it was stopped or never ran.
    pub fn tip(&self) -> Option<usize> {
        let ops = &self.run.flat.ops;
        let mut at = 0;
        loop {
            let op = ops.get(at)?;
            let below = match op.code {
                Code::Leaf | Code::Wait => None,
                code if code.is_composite() => {
                    Some(op.cursor as usize).filter(|_| op.cursor != NONE)
                }
                _ => Some(at + 1).filter(|c| is_valid(ops.get(*c).map(|op| op.status))),
            };
            match below {
                Some(child) => at = child,
                None if is_valid(Some(op.status)) => return Some(usize::from(op.node)),
                None => return None,
            }
        }
    }

    /// What a `Count` counted; `None` for another node.
    pub fn counts(&self, node: usize) -> Option<Counts> {
        let flat = &self.run.flat;
        let counter =
            |op: &&super::flat::Op| usize::from(op.node) == node && op.code == Code::Count;
        let op = flat.ops.iter().find(counter)?;
        flat.counts.get(usize::from(op.side)).copied()
    }

    /// The tree's own blackboard.
    pub fn local(&self) -> &Board {
        &self.local
    }

    /// The tree's own blackboard.
    pub fn local_mut(&mut self) -> &mut Board {
        &mut self.local
    }

    /// What happened in the last tick or reset.
    pub fn events(&self) -> &[Event] {
        self.run.events.list()
    }
}

fn is_valid(status: Option<NodeStatus>) -> bool {
    !matches!(
        status,
        None | Some(NodeStatus::Invalid | NodeStatus::Halting)
    )
}
