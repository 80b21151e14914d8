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
    /// How many leaves were told to stop and have not.
    pub(super) halting: usize,
}

impl<H: Host> Run<H> {
    /// Ticks the operation `i` with all it needs below.
    #[inline]
    pub(super) fn visit(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        if self.flat.ops[i].code == Code::Leaf {
            self.leaf_apart(i, cx)
        } else {
            self.tick(i, cx)
        }
    }

    /// For all but the composites: they do this in place, as a call for each
    /// of their leaves would cost as much as what it does.
    #[inline(never)]
    fn leaf_apart(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        self.leaf(i, cx)
    }

    /// Ticks an operation that is not a leaf.
    pub(super) fn tick(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = &mut self.flat.ops[i];
        let code = op.code;
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
        let seconds = match timer.seconds {
            In::Literal(seconds) => seconds,
            In::Key(_) => cx.get(&timer.seconds)?,
        };
        // Longer than a Duration can be is forever.
        let time = Duration::try_from_secs_f64(seconds.max(0.0)).unwrap_or(Duration::MAX);
        timer.deadline = cx.now.saturating_add(time);
        Ok(())
    }

    /// Gives the operation a status.
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, to: NodeStatus) {
        let op = &mut self.flat.ops[i];
        if op.status == to {
            return;
        }
        op.status = to;
        if !op.touched {
            op.touched = true;
            self.changed.push(u32::try_from(i).unwrap_or(NONE));
        }
    }

    /// Tells whose status is another one than after the tick before.
    #[inline]
    pub(super) fn tell(&mut self) {
        // As in most ticks.
        if !self.changed.is_empty() {
            self.tell_changes();
        }
    }

    fn tell_changes(&mut self) {
        for i in self.changed.drain(..) {
            let op = &mut self.flat.ops[i as usize];
            op.touched = false;
            let (from, to) = (op.shown, op.status);
            if from != to {
                op.shown = to;
                let stopped = matches!(to, NodeStatus::Invalid | NodeStatus::Halting);
                let reason = stopped.then_some(op.reason);
                let kind = EventKind::Status { from, to, reason };
                self.events.push(usize::from(op.node), kind);
            }
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
    #[allow(clippy::inline_always, reason = "most of the cost of a tick is here")]
    #[inline(always)]
    pub(super) fn answer(&mut self, i: usize, answer: Status, before: usize) -> Status {
        if self.halting > before && answer != Status::Running {
            return self.defer(i, answer);
        }
        self.set(i, answer.into());
        answer
    }

    #[cold]
    fn defer(&mut self, i: usize, answer: Status) -> Status {
        self.flat.ops[i].deferred = Some(answer);
        self.set(i, NodeStatus::Running);
        Status::Running
    }
}
