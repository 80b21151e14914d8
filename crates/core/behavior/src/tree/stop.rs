//! Stops nodes, at once or over several ticks.

use super::flat::{Code, NONE};
use super::leaf::{Cx, Halt, Host};
use super::run::Run;
use crate::status::{NodeStatus, ResetReason};

impl<H: Host> Run<H> {
    /// Makes the operation `i` invalid with all below it.
    pub(super) fn stop(&mut self, i: usize, reason: ResetReason, cx: &mut Cx<'_, '_, H>) {
        let op = &mut self.flat.ops[i];
        let (code, end) = (op.code, op.end as usize);
        // A result that waited for a halt is void: its node is stopped now.
        op.deferred = None;
        // A leaf that halts already keeps the reason for which it was stopped first.
        if op.status != NodeStatus::Halting {
            op.reason = reason;
        }
        match code {
            Code::Leaf => self.stop_leaf(i, reason, cx),
            Code::Wait => self.set(i, NodeStatus::Invalid),
            Code::Sequence { .. }
            | Code::SequenceWithMemory
            | Code::Selector { .. }
            | Code::Parallel => {
                op.cursor = NONE;
                // As in py_trees: first those that run, then all that are not invalid yet.
                if code == Code::Parallel {
                    self.stop_running_between(i + 1, end, reason, cx);
                }
                self.stop_between(i + 1, end, reason, cx);
                self.set(i, NodeStatus::Invalid);
            }
            _ => {
                if code == Code::Count {
                    let side = usize::from(op.side);
                    let interrupts = &mut self.flat.counts[side].interrupts;
                    *interrupts = interrupts.saturating_add(1);
                }
                // Also a child that is invalid already, as py_trees does.
                self.stop(i + 1, reason, cx);
                self.set(i, NodeStatus::Invalid);
            }
        }
    }

    fn stop_leaf(&mut self, i: usize, reason: ResetReason, cx: &mut Cx<'_, '_, H>) {
        let op = &self.flat.ops[i];
        let leaf = &mut self.flat.leaves[usize::from(op.side)];
        let mut to = NodeStatus::Invalid;
        match op.status {
            // Told once: a second call would count one leaf twice in `halting`.
            NodeStatus::Halting => return,
            NodeStatus::Running => {
                cx.node = usize::from(op.node);
                // Only a running leaf has something to halt; a finished one just becomes
                // invalid.
                if leaf.halt(cx, reason) == Halt::NotYet {
                    to = NodeStatus::Halting;
                }
            }
            _ => {}
        }
        // Also before it has halted: py_trees terminates a behaviour when it is stopped.
        leaf.invalidated();
        if to == NodeStatus::Halting {
            self.halting += 1;
        }
        self.set(i, to);
    }

    /// Stops the siblings from `first` up to `end` that are not invalid.
    #[inline(never)]
    pub(super) fn stop_between(
        &mut self,
        first: usize,
        end: usize,
        reason: ResetReason,
        cx: &mut Cx<'_, '_, H>,
    ) {
        let mut child = first;
        while child < end {
            let op = &self.flat.ops[child];
            let (next, status) = (op.end as usize, op.status);
            if self.renew(child, reason) {
                self.set(child, NodeStatus::Invalid);
            } else if !matches!(status, NodeStatus::Invalid | NodeStatus::Halting) {
                self.stop(child, reason, cx);
            }
            child = next;
        }
    }

    /// As [`Self::stop`] for a leaf that has finished, except for its status:
    /// a caller that ticks it next need not change the status in between.
    /// `false`, and no change, for all other operations.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn renew(&mut self, i: usize, reason: ResetReason) -> bool {
        let op = &mut self.flat.ops[i];
        let finished = matches!(op.status, NodeStatus::Success | NodeStatus::Failure);
        if op.code != Code::Leaf || !finished {
            return false;
        }
        op.deferred = None;
        op.reason = reason;
        self.flat.leaves[usize::from(op.side)].invalidated();
        true
    }

    /// Stops the siblings from `first` up to `end` that are running.
    pub(super) fn stop_running_between(
        &mut self,
        first: usize,
        end: usize,
        reason: ResetReason,
        cx: &mut Cx<'_, '_, H>,
    ) {
        let mut child = first;
        while child < end {
            let next = self.flat.ops[child].end as usize;
            if self.is_running(child) {
                self.stop(child, reason, cx);
            }
            child = next;
        }
    }

    /// Continues to halt the leaves that were told to stop; `true` when all have stopped.
    pub(super) fn drain(&mut self, cx: &mut Cx<'_, '_, H>) -> bool {
        for i in 0..self.flat.ops.len() {
            let op = &self.flat.ops[i];
            if op.status != NodeStatus::Halting {
                continue;
            }
            // The first reason is repeated in each call.
            let reason = op.reason;
            let leaf = &mut self.flat.leaves[usize::from(op.side)];
            cx.node = usize::from(op.node);
            if leaf.halt(cx, reason) == Halt::Done {
                self.halting = self.halting.saturating_sub(1);
                self.set(i, NodeStatus::Invalid);
            }
        }
        self.halting == 0
    }
}
