//! A tree, ready to run.
//!
//! What a change must not break:
//! - no memory is allocated in [`Tree::tick`], and its work is bounded by the number of nodes:
//!   it runs within a decision, and a test counts allocations;
//! - the state of a tree is its arrays, its board and nothing else, so that
//!   [`Tree::save`] is complete (ADR 0008). Leaves take `&self` for that reason;
//! - while a node halts no other node is ticked: the leaf that halts may still command
//!   the arm;
//! - indices of nodes are those of the graph, which traces, breakpoints and pictures use.

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

/// A behaviour tree. After [`Tree::new`] nothing of it uses the heap except
/// [`Tree::graph`] and a [`Tree::save`] into a vector that is too small, and
/// the work of a tick is bounded by the number of its nodes.
pub struct Tree<H: Host> {
    pub(super) run: Run<H>,
    pub(super) local: Board,
    /// Time of the tick before.
    pub(super) last: Option<Duration>,
    /// For records: hash of each operation, in the order of operations.
    pub(super) hashes: Vec<u64>,
    /// Hashes with their operations, sorted.
    pub(super) by_hash: Vec<(u64, usize)>,
    graph: Graph,
    pub(crate) noted: Vec<Finding>,
}

impl<H: Host> Tree<H> {
    /// Probable mistakes in the nodes of its file, as their types added them when they were
    /// made.
    pub fn noted(&self) -> &[Finding] {
        &self.noted
    }

    /// Makes `root` ready to run, with the tree's own blackboard.
    ///
    /// # Errors
    /// [`TreeError`] with all mistakes: duplicate ids, wrong numbers of children, more than
    /// [`super::MAX_NODES`] nodes, ...
    pub fn new(name: &str, root: Node<H>, local: Board) -> Result<Self, TreeError> {
        let Ready {
            flat,
            graph,
            hashes,
        } = flatten(name, root, &local)?;
        // Sorted once, so that a restore finds each entry of a checkpoint without a scan.
        let mut by_hash: Vec<(u64, usize)> = hashes.iter().copied().zip(0..).collect();
        by_hash.sort_unstable();
        // All memory for events is taken here; ticks do not allocate.
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

    /// Ticks the tree at time `now`, which must not decrease.
    ///
    /// While nodes halt, only they are called and the result is `Running`.
    pub fn tick(&mut self, now: Duration, shared: &mut Board, world: &mut H::World<'_>) -> Status {
        self.with_cx(now, shared, world, |run, cx| {
            // The root is visited in the tick in which the last node has halted, not one later.
            if run.halting > 0 && !run.drain(cx) {
                return Status::Running;
            }
            run.visit(0, cx)
        })
    }

    /// Stops everything. After `Done` the tree is as if it never ran;
    /// until then this has to be called again, once a tick.
    pub fn reset(
        &mut self,
        reason: ResetReason,
        now: Duration,
        shared: &mut Board,
        world: &mut H::World<'_>,
    ) -> Halt {
        let through = self.with_cx(now, shared, world, |run, cx| {
            // Those that halt already continue with their reason; stopping them again would
            // count a second interruption.
            if run.halting > 0 {
                run.drain(cx);
            }
            // Every operation is checked; most are invalid already after the root was stopped.
            for i in 0..run.flat.ops.len() {
                let status = run.flat.ops[i].status;
                if !matches!(status, NodeStatus::Invalid | NodeStatus::Halting) {
                    run.stop(i, reason, cx);
                }
            }
            run.halting == 0
        });
        // The state is kept until the last leaf has stopped, which needs it to halt.
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
        // Events of the last tick only: a reader takes them between two ticks.
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
        // After the work: a status that changed and changed back is not reported.
        self.run.report();
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
                // A halting leaf inside its modifiers is more important than their status.
                *last = NodeStatus::Halting;
            }
        }
    }

    /// The tree as a picture.
    pub fn graph(&self) -> Graph {
        self.graph.clone()
    }

    /// The deepest node that determined the tree's result, `py_trees`' tip; `None`
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

    /// The counts of a `Count` node; `None` for another node.
    pub fn counts(&self, node: usize) -> Option<Counts> {
        let flat = &self.run.flat;
        let counter =
            |op: &&super::flat::Op| usize::from(op.node) == node && op.code == Code::Count;
        let op = flat.ops.iter().find(counter)?;
        flat.counts.get(usize::from(op.side)).copied()
    }

    /// The tree's local blackboard.
    pub fn local(&self) -> &Board {
        &self.local
    }

    /// The tree's local blackboard.
    pub fn local_mut(&mut self) -> &mut Board {
        &mut self.local
    }

    /// The events of the last tick or reset.
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
