//! Replaced leaves, which return a fixed result without being run, to test the tree around
//! them.

use std::time::Duration;

use super::engine::Tree;
use super::flat::Code;
use super::leaf::{AnyLeaf, Cx, Halt, Host};
use crate::board::Fault;
use crate::status::{ResetReason, Status};
use crate::suggest;

/// The result that replaces that of a leaf from one time to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Replacement {
    /// The answer.
    pub answer: Status,
    /// The first time at which it is given.
    pub from: Duration,
    /// The first time at which it is not given any more; `None` for no end.
    pub until: Option<Duration>,
}

impl Replacement {
    fn applies(&self, now: Duration) -> bool {
        now >= self.from && self.until.is_none_or(|until| now < until)
    }
}

/// Why a leaf cannot be replaced.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReplaceError {
    /// No node has this id.
    #[error("unknown leaf '{id}'; {advice}")]
    Unknown {
        /// The id.
        id: String,
        /// The nearest id, or all of them.
        advice: String,
    },
    /// It is another kind of node.
    #[error("'{id}' is a {kind}, only leaves are replaced; name one of those below it")]
    NoLeaf {
        /// The id.
        id: String,
        /// Type of the node.
        kind: String,
    },
}

impl<H: Host> Tree<H> {
    /// The leaf `id` returns the result of the first of `replacements` that applies. A leaf that
    /// runs when one starts to apply is stopped; it starts again when none applies any more. To
    /// be called before the first tick: checkpoints of the tree differ from those without
    /// replacements.
    ///
    /// # Errors
    /// [`ReplaceError`] for an id that is not of a leaf.
    pub fn replace(
        &mut self,
        id: &str,
        replacements: Vec<Replacement>,
    ) -> Result<(), ReplaceError> {
        let graph = self.graph();
        let ops = &self.run.flat.ops;
        let is_leaf = |node: usize| {
            let op = ops
                .iter()
                .find(|op| usize::from(op.node) == node && op.code == Code::Leaf);
            op.map(|op| usize::from(op.side))
        };
        let Some(node) = graph.nodes.iter().position(|node| node.id == id) else {
            let leaves = graph.nodes.iter().enumerate();
            let leaves = leaves.filter(|(index, _)| is_leaf(*index).is_some());
            let ids: Vec<&str> = leaves.map(|(_, node)| node.id.as_str()).collect();
            return Err(ReplaceError::Unknown {
                id: id.to_owned(),
                advice: suggest::advice(id, &ids),
            });
        };
        let Some(side) = is_leaf(node) else {
            let kind = graph.nodes.get(node).map(|node| node.kind.clone());
            return Err(ReplaceError::NoLeaf {
                id: id.to_owned(),
                kind: kind.unwrap_or_default(),
            });
        };
        // The leaf is kept inside, since it runs while no replacement applies.
        if let Some(leaf) = self.run.flat.leaves.get_mut(side) {
            let inner = std::mem::replace(leaf, Box::new(Nothing));
            *leaf = Box::new(Replaced {
                inner,
                replacements,
                runs: false,
            });
        }
        Ok(())
    }
}

/// In the place of a leaf while it is being wrapped.
struct Nothing;

impl<H: Host> AnyLeaf<H> for Nothing {
    fn tick(&mut self, _: bool, _: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        Ok(Status::Failure)
    }

    fn halt(&mut self, _: &mut Cx<'_, '_, H>, _: ResetReason) -> Halt {
        Halt::Done
    }

    fn invalidated(&mut self) {}

    fn save(&self, _: &mut Vec<u8>) {}

    fn restore(&mut self, bytes: &[u8]) -> bool {
        bytes.is_empty()
    }

    fn forget(&mut self) {}
}

struct Replaced<H: Host> {
    inner: Box<dyn AnyLeaf<H>>,
    replacements: Vec<Replacement>,
    /// The leaf itself was started, and has not ended. Part of the checkpoint.
    runs: bool,
}

impl<H: Host> AnyLeaf<H> for Replaced<H> {
    fn tick(&mut self, begins: bool, cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        let now = cx.now;
        let applies = self.replacements.iter().find(|r| r.applies(now));
        if let Some(answer) = applies.map(|replacement| replacement.answer) {
            // A leaf that needs several ticks to stop is halted again in the next tick.
            self.runs = self.runs && self.inner.halt(cx, ResetReason::Explicit) == Halt::NotYet;
            return Ok(answer);
        }
        // After a replacement the node may be running, but the leaf itself was never started.
        let begins = begins || !self.runs;
        self.runs = false;
        let answer = self.inner.tick(begins, cx)?;
        // Not set on an error: the node fails, and a failed leaf must not be halted.
        self.runs = answer == Status::Running;
        Ok(answer)
    }

    fn halt(&mut self, cx: &mut Cx<'_, '_, H>, reason: ResetReason) -> Halt {
        if !self.runs {
            return Halt::Done;
        }
        let halt = self.inner.halt(cx, reason);
        self.runs = halt == Halt::NotYet;
        halt
    }

    fn invalidated(&mut self) {
        self.inner.invalidated();
    }

    fn save(&self, record: &mut Vec<u8>) {
        self.inner.save(record);
        // The flag is last, so that the state of the leaf has the same bytes as without the
        // wrapper.
        record.push(u8::from(self.runs));
    }

    fn restore(&mut self, bytes: &[u8]) -> bool {
        let Some((runs, inner)) = bytes.split_last() else {
            return false;
        };
        let whole = self.inner.restore(inner);
        self.runs = whole && *runs != 0;
        whole
    }

    fn forget(&mut self) {
        self.inner.forget();
        self.runs = false;
    }
}
