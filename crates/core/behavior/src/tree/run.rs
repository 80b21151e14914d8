//! One tick of one node.

use std::time::Duration;

use super::event::{EventKind, Events};
use super::flat::{Code, Flat, Held, NONE};
use super::leaf::{Cx, Host};
use crate::board::{Fault, In};
use crate::status::{NodeStatus, Status};

/// The running part of a tree.
pub(super) struct Run<H: Host> {
    pub(super) flat: Flat<H>,
    pub(super) events: Events,
    /// Operations whose status changed during this tick.
    pub(super) changed: Vec<u32>,
    /// The number of leaves that were told to stop and have not stopped yet.
    pub(super) halting: usize,
}

impl<H: Host> Run<H> {
    /// Ticks the operation `i` and, as needed, those below it.
    #[inline]
    pub(super) fn visit(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        if self.flat.ops[i].code == Code::Leaf {
            self.leaf_apart(i, cx)
        } else {
            self.tick(i, cx)
        }
    }

    /// For callers other than the composites, which inline the call: a function call for each
    /// of their leaves would cost as much as the leaf's own bookkeeping.
    #[inline(never)]
    fn leaf_apart(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        self.leaf(i, cx)
    }

    /// Ticks an operation that is not a leaf.
    pub(super) fn tick(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &mut self.flat.ops[i];
        let code = op.code;
        // The result of a run whose children had to halt first. It is delivered once, without
        // running the node again.
        if let Some(answer) = op.deferred {
            op.deferred = None;
            self.set(i, answer.into());
            return answer;
        }
        match code {
            Code::Leaf => self.leaf_apart(i, cx),
            Code::Sequence { memory } => self.sequence(i, memory, cx),
            Code::Selector { memory } => self.selector(i, memory, cx),
            Code::SequenceWithMemory => self.sequence_with_memory(i, cx),
            Code::Parallel => self.parallel(i, cx),
            Code::Wait => self.wait(i, cx),
            Code::Check => self.check(i, cx),
            Code::EternalGuard => self.guard(i, cx),
            Code::Delay => self.delay(i, cx),
            Code::OneShot { .. } => self.one_shot(i, cx),
            _ => self.decorator(i, cx),
        }
    }

    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn leaf(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &self.flat.ops[i];
        let leaf = &mut self.flat.leaves[usize::from(op.side)];
        cx.node = usize::from(op.node);
        let status = match leaf.tick(op.status != NodeStatus::Running, cx) {
            Ok(status) => status,
            // A fault of a port is a failure of the node: a leaf without its input must not
            // act.
            Err(fault) => self.fault(i, fault),
        };
        self.set(i, status.into());
        status
    }

    #[inline(never)]
    fn wait(&mut self, i: usize, cx: &Cx<'_, '_, H>) -> Status {
        if !self.is_running(i)
            && let Err(fault) = self.arm(i, cx)
        {
            let status = self.fault(i, fault);
            self.set(i, status.into());
            return status;
        }
        // At the deadline it is over: a wait of 0 s succeeds in its first tick.
        let status = if cx.now >= self.deadline(i) {
            Status::Success
        } else {
            Status::Running
        };
        self.set(i, status.into());
        status
    }

    /// Whether the operation is not finished.
    #[inline]
    pub(super) fn is_running(&self, i: usize) -> bool {
        self.flat.ops[i].status == NodeStatus::Running
    }

    pub(super) fn deadline(&self, i: usize) -> Duration {
        let side = usize::from(self.flat.ops[i].side);
        self.flat.timers[side].deadline
    }

    /// Starts the timer of an operation.
    pub(super) fn arm(&mut self, i: usize, cx: &Cx<'_, '_, H>) -> Result<(), Fault> {
        let side = usize::from(self.flat.ops[i].side);
        let timer = &mut self.flat.timers[side];
        // A time from a key is read at the start only: a deadline that moved would not be one.
        let seconds = match timer.seconds {
            In::Literal(seconds) => seconds,
            In::Key(_) => cx.get(&timer.seconds)?,
        };
        // More seconds than a `Duration` can hold mean "for ever".
        let time = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX);
        // Saturating: `now` plus "for ever" must not overflow.
        timer.deadline = cx.now.saturating_add(time);
        Ok(())
    }

    /// Gives the operation a status.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, to: NodeStatus) {
        let op = &mut self.flat.ops[i];
        // Most operations keep their status in most ticks.
        if op.status == to {
            return;
        }
        op.status = to;
        // Once per tick, so that `changed` never grows beyond its reserved length.
        if !op.touched {
            op.touched = true;
            self.changed.push(u32::try_from(i).unwrap_or(NONE));
        }
    }

    /// Reports the nodes whose status differs from that after the tick before.
    #[inline]
    pub(super) fn report(&mut self) {
        // In most ticks nothing has changed.
        if !self.changed.is_empty() {
            self.report_changes();
        }
    }

    fn report_changes(&mut self) {
        for i in self.changed.drain(..) {
            let op = &mut self.flat.ops[i as usize];
            op.touched = false;
            let (from, to) = (op.shown, op.status);
            // Compared with the reported status: a change that was reversed is not an event.
            if from != to {
                op.shown = to;
                let stopped = matches!(to, NodeStatus::Invalid | NodeStatus::Halting);
                let reason = stopped.then_some(op.reason);
                let kind = EventKind::Status { from, to, reason };
                self.events.push(usize::from(op.node), kind);
            }
        }
    }

    /// Stores the result of a guard, and reports it if it has changed.
    pub(super) fn note_guard(&mut self, i: usize, holds: bool) {
        let op = &mut self.flat.ops[i];
        let held = Held::from(holds);
        if op.held != held {
            op.held = held;
            let kind = EventKind::Guard { holds };
            self.events.push(usize::from(op.node), kind);
        }
    }

    /// Reports the reason for which a node fails.
    pub(super) fn fault(&mut self, i: usize, fault: Fault) -> Status {
        let node = usize::from(self.flat.ops[i].node);
        self.events.push(node, EventKind::Fault(fault));
        Status::Failure
    }

    /// Sets the result of an operation, after all nodes that halt because of it have
    /// halted: `before` is the number of halting leaves before it stopped any.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn answer(&mut self, i: usize, answer: Status, before: usize) -> Status {
        // The parent must not continue while a stopped leaf still moves the arm.
        if self.halting > before && answer != Status::Running {
            return self.defer(i, answer);
        }
        self.set(i, answer.into());
        answer
    }

    #[cold]
    fn defer(&mut self, i: usize, answer: Status) -> Status {
        self.flat.ops[i].deferred = Some(answer);
        // Running, so that the parent returns to this operation in the next tick.
        self.set(i, NodeStatus::Running);
        Status::Running
    }
}
