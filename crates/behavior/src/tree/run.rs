//! One tick of one node.

use std::time::Duration;

use super::event::{EventKind, Events};
use super::flat::{Code, Flat, Held};
use super::leaf::{Cx, Host};
use crate::board::{Fault, In};
use crate::status::{NodeStatus, ResetReason, Status};

/// The running part of a tree.
pub(super) struct Run<H: Host> {
    pub(super) flat: Flat<H>,
    pub(super) events: Events,
    /// How many leaves were told to stop and have not.
    pub(super) halting: usize,
}

impl<H: Host> Run<H> {
    /// Ticks the operation `i` with all it needs below.
    pub(super) fn tick(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &mut self.flat.ops[i];
        let code = op.code;
        if let Some(answer) = op.deferred.take() {
            self.set(i, answer.into(), None);
            return answer;
        }
        match code {
            Code::Leaf => self.leaf(i, cx),
            Code::Sequence { memory } => self.sequence(i, memory, cx),
            Code::Selector { memory } => self.selector(i, memory, cx),
            Code::Parallel => self.parallel(i, cx),
            Code::Wait => self.wait(i, cx),
            Code::Check => self.check(i, cx),
            Code::EternalGuard => self.guard(i, cx),
            Code::Delay => self.delay(i, cx),
            Code::OneShot { .. } => self.one_shot(i, cx),
            _ => self.decorator(i, cx),
        }
    }

    #[inline]
    fn leaf(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &self.flat.ops[i];
        let leaf = &mut self.flat.leaves[usize::from(op.side)];
        cx.node = usize::from(op.node);
        let started = match op.status {
            NodeStatus::Running => Ok(()),
            _ => leaf.start(cx),
        };
        let status = match started.and_then(|()| leaf.tick(cx)) {
            Ok(status) => status,
            Err(fault) => self.fault(i, fault),
        };
        self.set(i, status.into(), None);
        status
    }

    fn wait(&mut self, i: usize, cx: &Cx<'_, '_, H>) -> Status {
        if !self.is_running(i)
            && let Err(fault) = self.arm(i, cx)
        {
            let status = self.fault(i, fault);
            self.set(i, status.into(), None);
            return status;
        }
        let status = if cx.now >= self.deadline(i) {
            Status::Success
        } else {
            Status::Running
        };
        self.set(i, status.into(), None);
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
        let seconds = match timer.seconds {
            In::Literal(seconds) => seconds,
            In::Key(_) => cx.get(&timer.seconds)?,
        };
        // Longer than a Duration can be is for ever.
        let time = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX);
        timer.deadline = cx.now.saturating_add(time);
        Ok(())
    }

    /// Gives the operation a status, and notes it if it is that of its node.
    #[inline]
    pub(super) fn set(&mut self, i: usize, to: NodeStatus, reason: Option<ResetReason>) {
        let op = &mut self.flat.ops[i];
        let from = op.status;
        if from == to {
            return;
        }
        op.status = to;
        if op.outermost {
            let kind = EventKind::Status { from, to, reason };
            self.events.push(usize::from(op.node), kind);
        }
    }

    /// Notes what a guard answered, if it is news.
    pub(super) fn note_guard(&mut self, i: usize, holds: bool) {
        let op = &mut self.flat.ops[i];
        let held = Held::from(holds);
        if op.held != held {
            op.held = held;
            let kind = EventKind::Guard { holds };
            self.events.push(usize::from(op.node), kind);
        }
    }

    /// Notes why a node fails.
    pub(super) fn fault(&mut self, i: usize, fault: Fault) -> Status {
        let node = usize::from(self.flat.ops[i].node);
        self.events.push(node, EventKind::Fault(fault));
        Status::Failure
    }

    /// The answer of an operation, with whatever still halts because of it
    /// awaited: `before` is how many were halting before it stopped any.
    pub(super) fn answer(&mut self, i: usize, answer: Status, before: usize) -> Status {
        let now = if self.halting > before && answer != Status::Running {
            self.flat.ops[i].deferred = Some(answer);
            Status::Running
        } else {
            answer
        };
        self.set(i, now.into(), None);
        now
    }
}
