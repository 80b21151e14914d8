//! Checks of a blackboard key, and the siblings that they may interrupt.

use super::flat::{Code, Held};
use super::leaf::{Cx, Host};
use super::run::Run;
use super::spec::{Abort, Test};
use crate::board::Scope;
use crate::status::{ResetReason, Status};
use crate::value::Value;

impl<H: Host> Run<H> {
    #[inline(never)]
    pub(super) fn check(&mut self, i: usize, cx: &mut Cx<'_, '_, H>) -> Status {
        let side = usize::from(self.flat.ops[i].side);
        let abort = self.flat.checks[side].abort;
        // While the node runs, only a check that may abort its own node is evaluated again.
        let asks = !self.is_running(i) || matches!(abort, Abort::Own | Abort::Both);
        if asks && !self.ask(i, cx) {
            return self.done(i, Status::Failure, ResetReason::Aborted, cx);
        }
        let answer = self.visit(i + 1, cx);
        // The check is evaluated again after the node has finished, and its result is stored:
        // it must not count as "holds again" in the next tick because the node itself wrote the
        // key.
        if answer != Status::Running && interrupts(abort) {
            // A change that the node itself made to the key is not a reason to interrupt its
            // siblings.
            self.ask(i, cx);
        }
        self.done(i, answer, ResetReason::ParentDone, cx)
    }

    /// Evaluates the check `i` and stores the result.
    fn ask(&mut self, i: usize, cx: &Cx<'_, '_, H>) -> bool {
        let side = usize::from(self.flat.ops[i].side);
        let check = &self.flat.checks[side];
        let board = match check.slot.scope {
            Scope::Local => &*cx.local,
            Scope::Shared => &*cx.shared,
        };
        let holds = holds(check.test, board.value_ref(check.slot.index));
        self.note_guard(i, holds);
        holds
    }

    /// The first child from `first` up to `running` with a check that did not
    /// hold before and holds now, so that it takes over from `running`.
    pub(super) fn interrupting(
        &mut self,
        first: usize,
        running: usize,
        cx: &Cx<'_, '_, H>,
    ) -> Option<usize> {
        let mut child = first;
        while child < running {
            if self.takes_over(child, cx) {
                return Some(child);
            }
            child = self.flat.ops[child].end as usize;
        }
        None
    }

    /// Whether a check of the node at `start` holds again, and all its others that may
    /// interrupt hold, too.
    fn takes_over(&mut self, start: usize, cx: &Cx<'_, '_, H>) -> bool {
        let node = self.flat.ops[start].node;
        let (mut at, mut again, mut all) = (start, false, true);
        // All are evaluated, without an early end: each stores its result, and a skipped one
        // would report its change later than it happened.
        while let Some(op) = self.flat.ops.get(at).filter(|op| op.node == node) {
            let side = usize::from(op.side);
            let before = op.held;
            if op.code == Code::Check && interrupts(self.flat.checks[side].abort) {
                let holds = self.ask(at, cx);
                again |= holds && before != Held::Yes;
                all &= holds;
            }
            at += 1;
        }
        again && all
    }
}

fn interrupts(abort: Abort) -> bool {
    matches!(abort, Abort::LowerPriority | Abort::Both)
}

fn holds(test: Test, value: Option<&Value>) -> bool {
    // Integers and numbers are compared as numbers; a missing value is neither below nor above.
    let number = || match value {
        Some(Value::Number(number)) => Some(*number),
        Some(Value::Integer(number)) => Some(*number as f64),
        _ => None,
    };
    match test {
        Test::IsSet => value.is_some(),
        Test::IsUnset => value.is_none(),
        Test::Equals(wanted) => value == Some(&wanted),
        Test::Differs(wanted) => value != Some(&wanted),
        Test::Below(limit) => number().is_some_and(|n| n < limit),
        Test::Above(limit) => number().is_some_and(|n| n > limit),
    }
}
