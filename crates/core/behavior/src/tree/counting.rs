//! Composites of BehaviorTree.CPP that `py_trees` does not have. ADR 0027: an imported tree is
//! accepted only if each node gives the same result in every tick.

use super::flat::{NONE, Needs};
use super::leaf::{Cx, Host};
use super::run::Run;
use crate::status::{NodeStatus, Status};

/// The number of children of a parallel that have finished.
#[derive(Clone, Copy, Default)]
struct Tally {
    children: u32,
    successes: u32,
    failures: u32,
}

impl Tally {
    fn add(&mut self, answer: Status) {
        match answer {
            Status::Success => self.successes += 1,
            Status::Failure => self.failures += 1,
            Status::Running => {}
        }
    }

    /// The result as soon as it is certain.
    fn decides(self, successes: u32, failures: u32) -> Option<Status> {
        // Success is compared first, as in BehaviorTree.CPP.
        if self.successes >= successes {
            return Some(Status::Success);
        }
        // Failed children cannot succeed any more.
        let reachable = self.children - self.failures;
        (reachable < successes || self.failures >= failures).then_some(Status::Failure)
    }
}

impl<H: Host> Run<H> {
    /// A parallel that counts successes and failures: its result, and the child that determined
    /// it. `None`, with no child ticked, for one with another policy.
    pub(super) fn counting(
        &mut self,
        side: usize,
        first: usize,
        end: usize,
        cx: &mut Cx<'_, '_, H>,
    ) -> Option<(Status, u32)> {
        let (successes, failures) = match self.flat.policies[side].needs {
            Needs::Count {
                successes,
                failures,
            } => (Some(successes), failures),
            Needs::Finish { failures } => (None, failures),
            _ => return None,
        };
        // Children that finished in earlier ticks count from the start of this one.
        let mut tally = self.tally(first, end);
        let (mut child, mut last) = (first, NONE);
        while child < end {
            if !self.has_finished(child) {
                tally.add(self.visit(child, cx));
            }
            last = u32::try_from(child).unwrap_or(NONE);
            // After each child, so that those behind the deciding one are not ticked, as in
            // BehaviorTree.CPP.
            if let Some(answer) = successes.and_then(|least| tally.decides(least, failures)) {
                return Some((answer, last));
            }
            child = self.flat.ops[child].end as usize;
        }
        // `ParallelAll` ends when all have finished, also after enough failures.
        let answer = match tally.successes + tally.failures == tally.children {
            false => Status::Running,
            true if tally.children > 0 && tally.failures >= failures => Status::Failure,
            true => Status::Success,
        };
        Some((answer, last))
    }

    fn tally(&self, first: usize, end: usize) -> Tally {
        let (mut tally, mut child) = (Tally::default(), first);
        while child < end {
            tally.children += 1;
            match self.flat.ops[child].status {
                NodeStatus::Success => tally.successes += 1,
                NodeStatus::Failure => tally.failures += 1,
                _ => {}
            }
            child = self.flat.ops[child].end as usize;
        }
        tally
    }

    fn has_finished(&self, child: usize) -> bool {
        let status = self.flat.ops[child].status;
        matches!(status, NodeStatus::Success | NodeStatus::Failure)
    }

    #[inline(never)]
    pub(super) fn sequence_with_memory(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let op = self.flat.ops[i];
        let (mut child, end) = (i + 1, op.end as usize);
        for _ in 0..op.counter {
            // An edited file may have fewer children than the restored counter.
            child = self.flat.ops.get(child).map_or(end, |op| op.end as usize);
        }
        child = child.min(end);
        let before = self.halting;
        let mut answer = Status::Success;
        while child < end {
            // The current child, for pictures and the tip of the tree.
            self.flat.ops[i].cursor = u32::try_from(child).unwrap_or(NONE);
            let started = !self.is_running(child);
            answer = self.visit(child, cx);
            if answer != Status::Success {
                break;
            }
            // Kept over a failure and a stop: the next run continues with the child that
            // failed.
            self.flat.ops[i].counter += 1;
            child = self.flat.ops[child].end as usize;
            // As BehaviorTree.CPP, which returns after a child that was started in this tick.
            if started && child < end {
                answer = Status::Running;
                break;
            }
        }
        // Only a whole pass starts from the first child again.
        if answer == Status::Success {
            self.flat.ops[i].counter = 0;
        }
        self.answer(i, answer, before)
    }
}
