//! Nodes around one child: decorators, and modifiers without a test.

use super::flat::Code;
use super::leaf::{Cx, Host};
use super::run::Run;
use crate::status::{ResetReason, Status};

impl<H: Host> Run<H> {
    /// The operations that tick the child first and convert its result.
    #[inline(never)]
    pub(super) fn decorator(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let code = self.flat.ops[i].code;
        // A new run: counters of the last one must not shorten it. A retry with a budget keeps
        // its count over runs, until the tree is reset.
        if !self.is_running(i) {
            match code {
                Code::Repeat { .. } | Code::Retry { budget: false, .. } | Code::Again { .. } => {
                    self.flat.ops[i].counter = 0;
                }
                Code::Timeout => {
                    // A deadline from a key may be missing; the node then fails before its
                    // child starts.
                    if let Err(fault) = self.arm(i, cx) {
                        let answer = self.fault(i, fault);
                        return self.done(i, answer, ResetReason::ParentDone, cx);
                    }
                }
                _ => {}
            }
        }
        // Before the visit: a child that finishes in the tick in which it starts counts as one
        // that did not run before.
        let was_running = self.is_running(i + 1);
        let child = self.visit(i + 1, cx);
        // After the child: one that finishes in the late tick wins over the timeout (py_trees).
        if code == Code::Timeout && child == Status::Running && cx.now > self.deadline(i) {
            return self.done(i, Status::Failure, ResetReason::TimedOut, cx);
        }
        let mut answer = self.made_of(i, code, child);
        let ended = was_running && !self.is_running(i + 1);
        if matches!(code, Code::Again { .. }) && ended && answer == Status::Running {
            // This run started in this tick, so there is no third one.
            let child = self.visit(i + 1, cx);
            answer = self.made_of(i, code, child);
        }
        self.done(i, answer, ResetReason::ParentDone, cx)
    }

    /// Returns the result; a child that still runs when this is finished is stopped.
    pub(super) fn done(
        &mut self,
        i: usize,
        answer: Status,
        reason: ResetReason,
        cx: &mut Cx<'_, '_, H>,
    ) -> Status {
        let before = self.halting;
        if answer != Status::Running && self.is_running(i + 1) {
            self.stop(i + 1, reason, cx);
        }
        self.answer(i, answer, before)
    }

    /// The result of the decorator for that of its child.
    fn made_of(&mut self, i: usize, code: Code, child: Status) -> Status {
        match (code, child) {
            (Code::Inverter, Status::Success) => Status::Failure,
            (Code::Inverter, Status::Failure) => Status::Success,
            (Code::Converter { from, to }, answer) if answer == from => to,
            (Code::Force(status), Status::Success | Status::Failure) => status,
            (Code::Condition(wanted), answer) if answer == wanted => Status::Success,
            (Code::Condition(_), _) => Status::Running,
            (
                Code::Repeat {
                    count,
                    break_on_failure,
                },
                answer,
            ) => self.repeated(i, count, break_on_failure, answer),
            (Code::Retry { count, budget }, answer) => self.retried(i, count, budget, answer),
            (
                Code::Again {
                    count,
                    on_failure: true,
                },
                answer,
            ) => self.retried(i, count, false, answer),
            (Code::Again { count, .. }, answer) => self.repeated(i, count, true, answer),
            (Code::Count, answer) => self.counted(i, answer),
            (_, answer) => answer,
        }
    }

    fn repeated(&mut self, i: usize, count: u32, break_on_failure: bool, child: Status) -> Status {
        if child == Status::Running || (child == Status::Failure && break_on_failure) {
            return child;
        }
        let runs = &mut self.flat.ops[i].counter;
        // Saturating: an endless repeat must not overflow after four billion runs.
        *runs = runs.saturating_add(1);
        if count > 0 && *runs >= count {
            Status::Success
        } else {
            Status::Running
        }
    }

    fn retried(&mut self, i: usize, count: u32, budget: bool, child: Status) -> Status {
        let failures = &mut self.flat.ops[i].counter;
        match child {
            Status::Running => Status::Running,
            Status::Success => {
                // A budget holds for the whole life of the tree.
                if !budget {
                    *failures = 0;
                }
                Status::Success
            }
            Status::Failure => {
                *failures = failures.saturating_add(1);
                if count > 0 && *failures >= count {
                    Status::Failure
                } else {
                    Status::Running
                }
            }
        }
    }

    fn counted(&mut self, i: usize, child: Status) -> Status {
        let side = usize::from(self.flat.ops[i].side);
        let counts = &mut self.flat.counts[side];
        let own = match child {
            Status::Running => &mut counts.running,
            Status::Success => &mut counts.successes,
            Status::Failure => &mut counts.failures,
        };
        *own = own.saturating_add(1);
        counts.ticks = counts.ticks.saturating_add(1);
        child
    }

    #[inline(never)]
    pub(super) fn one_shot(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &self.flat.ops[i];
        let code = op.code;
        // The result of the first completed run, for ever; the child is not visited again.
        if let Some(last) = op.last {
            return self.done(i, last, ResetReason::ParentDone, cx);
        }
        let answer = self.visit(i + 1, cx);
        let over = match answer {
            Status::Success => true,
            Status::Failure => code == Code::OneShot { on_failure: true },
            Status::Running => false,
        };
        if over {
            self.flat.ops[i].last = Some(answer);
        }
        self.done(i, answer, ResetReason::ParentDone, cx)
    }

    #[inline(never)]
    pub(super) fn guard(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &self.flat.ops[i];
        let leaf = &mut self.flat.leaves[usize::from(op.side)];
        cx.node = usize::from(op.node);
        // A fault counts as "does not hold": the guarded child must not run on unknown data.
        let holds = match leaf.tick(true, cx) {
            Ok(status) => status == Status::Success,
            Err(fault) => self.fault(i, fault) == Status::Success,
        };
        self.note_guard(i, holds);
        // The child is stopped in the same tick in which the guard fails.
        if !holds {
            return self.done(i, Status::Failure, ResetReason::Aborted, cx);
        }
        let answer = self.visit(i + 1, cx);
        self.done(i, answer, ResetReason::ParentDone, cx)
    }

    #[inline(never)]
    pub(super) fn delay(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        if !self.is_running(i) {
            // A new run: `open` may be set from the last one, which would skip the delay.
            self.flat.ops[i].open = false;
            if let Err(fault) = self.arm(i, cx) {
                let answer = self.fault(i, fault);
                return self.done(i, answer, ResetReason::ParentDone, cx);
            }
        }
        if !self.flat.ops[i].open {
            if cx.now < self.deadline(i) {
                return self.answer(i, Status::Running, self.halting);
            }
            self.flat.ops[i].open = true;
        }
        let answer = self.visit(i + 1, cx);
        self.done(i, answer, ResetReason::ParentDone, cx)
    }
}
