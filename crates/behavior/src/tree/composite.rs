//! Sequence, Selector and Parallel, as `py_trees` has them.

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
        if op.status != NodeStatus::Running {
            self.restart(i, op, cx);
        } else if memory && op.cursor != NONE {
            child = op.cursor as usize;
            if op.watches
                && let Some(left) = self.interrupting(first, child, cx)
            {
                child = left;
                if self.interrupt(i, left, end, cx) {
                    return Status::Running;
                }
            }
        }
        let before = self.halting;
        let (mut answer, mut last) = (Status::Success, op.cursor);
        while child < end {
            last = index(child);
            let next;
            (answer, next) = self.child(child, cx);
            if answer != Status::Success {
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

    /// Makes the children of a sequence that restarts invalid.
    #[inline]
    fn restart(&mut self, i: usize, op: Op, cx: &mut Cx<'_, '_, H>) {
        // Beyond the current child none has run since all were stopped.
        let ran = match op.cursor {
            _ if op.open => op.end,
            NONE => return,
            current => self.flat.ops[current as usize].end,
        };
        self.flat.ops[i].open = false;
        let (mut stale, ran) = (i + 1, ran as usize);
        // The first one is ticked next, and needs not be told apart.
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
        // Nothing is new in most ticks.
        if answer == Status::Running && op.status == NodeStatus::Running {
            return answer;
        }
        self.answer(i, answer, before)
    }

    /// Ticks a child, and says where the next one is. As [`Run::visit`], but
    /// what is most frequent is done in place, or called without a detour.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    fn child(&mut self, child: usize, cx: &mut Cx<'_, '_, H>) -> (Status, usize) {
        let op = &self.flat.ops[child];
        let next = op.end as usize;
        let answer = match op.code {
            Code::Leaf => self.leaf(child, cx),
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
        if op.status != NodeStatus::Running {
            self.stop_between(first, end, ResetReason::ParentDone, cx);
            self.flat.ops[i].cursor = NONE;
        }
        if let Some((answer, last)) = self.counting(side, first, end, cx) {
            return self.parallel_done(i, answer, last, cx);
        }
        let skip = self.flat.policies[side].synchronise;
        let mut child = first;
        while child < end {
            if !(skip && self.flat.ops[child].status == NodeStatus::Success) {
                self.visit(child, cx);
            }
            child = self.flat.ops[child].end as usize;
        }
        let (answer, current) = self.parallel_answer(side, first, end);
        self.parallel_done(i, answer, current, cx)
    }

    /// Answers; children that still run when this is finished are stopped.
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

    /// The answer, and the child that gave it.
    fn parallel_answer(&self, side: usize, first: usize, end: usize) -> (Status, u32) {
        let (mut child, mut last) = (first, NONE);
        let (mut succeeded, mut all) = (NONE, true);
        while child < end {
            let op = &self.flat.ops[child];
            last = index(child);
            match op.status {
                NodeStatus::Failure => return (Status::Failure, last),
                NodeStatus::Success => succeeded = last,
                _ => all = false,
            }
            child = op.end as usize;
        }
        let (done, current) = match &self.flat.policies[side].needs {
            _ if first == end => (true, NONE),
            // Those that count were answered by `counting`.
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

    /// Stops what runs because the child `left` of `i` takes over. `true` if
    /// something takes its time for it; `left` has to wait then.
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
