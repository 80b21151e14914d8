//! Sequence, Selector and Parallel with the semantics of `py_trees`.
//!
//! Every rule here has a row in the conformance tests, which compare results, statuses and
//! counts of calls with those of `py_trees`. The rules that are easy to break:
//! - a selector stops lower children only if the child that answers is not the one that was
//!   current at the start of the tick;
//! - a sequence that restarts makes the children of its last run invalid before it ticks one;
//! - children that still run are stopped when a parallel is finished;
//! - a child that takes over by its check has to wait until the interrupted one has halted:
//!   two leaves would command the arm in one tick.

use super::flat::{Code, NONE, Needs, Op};
use super::leaf::{Cx, Host};
use super::run::Run;
use crate::status::{NodeStatus, ResetReason, Status};

impl<H: Host> Run<H> {
    #[inline(never)]
    pub(super) fn sequence(&mut self, i: usize, memory: bool, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = self.flat.ops[i];
        let (first, end) = (i + 1, op.end as usize);
        let mut child = first;
        // Not running means that this is a new run, for any cursor.
        if op.status != NodeStatus::Running {
            self.restart(i, op, cx);
        } else if memory && op.cursor != NONE {
            // With memory, children before the current one are not ticked again; a check of one
            // of them may still interrupt.
            child = op.cursor as usize;
            if op.watches
                && let Some(left) = self.interrupting(first, child, cx)
            {
                // The interrupted child may need ticks to halt, and the new one must not run
                // meanwhile.
                child = left;
                if self.interrupt(i, left, end, cx) {
                    return Status::Running;
                }
            }
        }
        // Compared at the end: if something began to halt in this call, the result waits for
        // it.
        let before = self.halting;
        let (mut answer, mut last) = (Status::Success, op.cursor);
        while child < end {
            last = index(child);
            let next;
            (answer, next) = self.child(child, cx);
            if answer != Status::Success {
                // Without memory, children behind may still be running from the tick before.
                if !memory {
                    let reason = match answer {
                        Status::Failure => ResetReason::Aborted,
                        _ => ResetReason::Preempted,
                    };
                    self.stop_between(next, end, reason, cx);
                }
                break;
            }
            child = next;
        }
        self.composed(i, last, answer, before)
    }

    /// Makes the children of the last run of a sequence invalid before it restarts.
    #[inline]
    fn restart(&mut self, i: usize, op: Op, cx: &mut Cx<'_, '_, H>) {
        // No child after the current one has run since all were stopped.
        let ran = match op.cursor {
            // After an edit of the file the order may have changed: all children are checked.
            _ if op.open => op.end,
            NONE => return,
            current => self.flat.ops[current as usize].end,
        };
        self.flat.ops[i].open = false;
        let (mut stale, ran) = (i + 1, ran as usize);
        // The first child is ticked next, so its status need not change to invalid in between.
        if stale < ran && self.renew(stale, ResetReason::ParentDone) {
            stale += 1;
        }
        if stale < ran {
            self.stop_between(stale, ran, ResetReason::ParentDone, cx);
        }
    }

    #[inline]
    pub(super) fn selector(&mut self, i: usize, memory: bool, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = self.flat.ops[i];
        let (first, end) = (i + 1, op.end as usize);
        // After it finished or was stopped the first child counts as current (py_trees).
        let running = op.status == NodeStatus::Running && op.cursor != NONE;
        let mut previous = if running { op.cursor as usize } else { first };
        let mut child = first;
        if memory {
            if running
                && op.watches
                && let Some(left) = self.interrupting(first, previous, cx)
            {
                previous = left;
                if self.interrupt(i, left, end, cx) {
                    return Status::Running;
                }
            }
            // With memory, children before the current one are marked as not run in this tick.
            child = previous;
            self.stop_between(first, child, ResetReason::ParentDone, cx);
        }
        let before = self.halting;
        let (mut answer, mut last) = (Status::Failure, NONE);
        while child < end {
            last = index(child);
            let next;
            (answer, next) = self.child(child, cx);
            if answer != Status::Failure {
                // Not if the same child answers again: nothing has taken over from the lower
                // ones, and py_trees does not stop them either.
                if child != previous {
                    self.stop_between(next, end, ResetReason::Preempted, cx);
                }
                break;
            }
            child = next;
        }
        self.composed(i, last, answer, before)
    }

    /// [`Run::answer`], given by the child `last`.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    fn composed(&mut self, i: usize, last: u32, answer: Status, before: usize) -> Status {
        let op = &mut self.flat.ops[i];
        op.cursor = last;
        // In most ticks nothing has changed.
        if answer == Status::Running && op.status == NodeStatus::Running {
            return answer;
        }
        self.answer(i, answer, before)
    }

    /// Ticks a child, and returns the place of the next one. As [`Run::visit`], but
    /// the most frequent cases are handled in place, or called directly.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    fn child(&mut self, child: usize, cx: &mut Cx<'_, '_, H>) -> (Status, usize) {
        let op = &self.flat.ops[child];
        let next = op.end as usize;
        let answer = match op.code {
            Code::Leaf => self.leaf(child, cx),
            // A deferred result has to be delivered by `tick`, before the node runs again.
            Code::Sequence { memory } if op.deferred.is_none() => self.sequence(child, memory, cx),
            _ => self.tick(child, cx),
        };
        (answer, next)
    }

    #[inline(never)]
    pub(super) fn parallel(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = self.flat.ops[i];
        let (first, end) = (i + 1, op.end as usize);
        let side = usize::from(op.side);
        // Results of the last run would count in this one: the policies read the statuses of
        // all children.
        if op.status != NodeStatus::Running {
            self.stop_between(first, end, ResetReason::ParentDone, cx);
            self.flat.ops[i].cursor = NONE;
        }
        // The counting policies tick the children themselves, up to the one that decides.
        if let Some((answer, last)) = self.counting(side, first, end, cx) {
            return self.parallel_done(i, answer, last, cx);
        }
        let skip = self.flat.policies[side].synchronise;
        let mut child = first;
        while child < end {
            // Synchronised: a child that succeeded keeps its status and is not ticked again.
            if !(skip && self.flat.ops[child].status == NodeStatus::Success) {
                self.visit(child, cx);
            }
            child = self.flat.ops[child].end as usize;
        }
        let (answer, current) = self.parallel_answer(side, first, end);
        self.parallel_done(i, answer, current, cx)
    }

    /// Returns the result; children that still run when the parallel is finished are stopped.
    fn parallel_done(
        &mut self,
        i: usize,
        answer: Status,
        current: u32,
        cx: &mut Cx<'_, '_, H>,
    ) -> Status {
        let (first, end) = (i + 1, self.flat.ops[i].end as usize);
        self.flat.ops[i].cursor = current;
        let before = self.halting;
        if answer != Status::Running {
            self.stop_running_between(first, end, ResetReason::ParentDone, cx);
        }
        self.answer(i, answer, before)
    }

    /// The result, and the child that determined it.
    fn parallel_answer(&self, side: usize, first: usize, end: usize) -> (Status, u32) {
        let (mut child, mut last) = (first, NONE);
        let (mut succeeded, mut all) = (NONE, true);
        while child < end {
            let op = &self.flat.ops[child];
            last = index(child);
            match op.status {
                // A failure wins over successes in every policy.
                NodeStatus::Failure => return (Status::Failure, last),
                NodeStatus::Success => succeeded = last,
                _ => all = false,
            }
            child = op.end as usize;
        }
        let (done, current) = match &self.flat.policies[side].needs {
            // Without children it succeeds, as in py_trees.
            _ if first == end => (true, NONE),
            // The counting policies returned from `counting` before.
            Needs::All | Needs::Count { .. } | Needs::Finish { .. } => (all, last),
            Needs::One => (succeeded != NONE, succeeded),
            Needs::Selected(children) => {
                let is_done = |c: &u32| self.flat.ops[*c as usize].status == NodeStatus::Success;
                let named_last = children.last().copied().unwrap_or(last);
                (children.iter().all(is_done), named_last)
            }
        };
        if done {
            (Status::Success, current)
        } else {
            (Status::Running, last)
        }
    }

    /// Stops the running children because the child `left` of `i` takes over. `true` if
    /// one of them needs more ticks to halt; `left` has to wait then.
    fn interrupt(&mut self, i: usize, left: usize, end: usize, cx: &mut Cx<'_, '_, H>) -> bool {
        let before = self.halting;
        let next = self.flat.ops[left].end as usize;
        self.stop_between(next, end, ResetReason::Preempted, cx);
        self.flat.ops[i].cursor = index(left);
        self.halting > before
    }
}

fn index(i: usize) -> u32 {
    // Trees have at most MAX_NODES operations.
    u32::try_from(i).unwrap_or(NONE)
}
