//! Leaves that answer without being run, for a test of the tree around them.

use std::time::Duration;

use super::engine::Tree;
use super::flat::Code;
use super::leaf::{AnyLeaf, Cx, Halt, Host};
use crate::board::Fault;
use crate::status::{ResetReason, Status};
use crate::suggest;

/// What a leaf answers from one time to another, in place of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Replacement {
    /// The answer.
    pub answer: Status,
    /// The first time at which it is given.
    pub from: Duration,
    /// The first time at which it is not given any more; `None` for ever.
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
    #[error("there is no leaf '{id}'; {advice}")]
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
    /// The leaf `id` answers as `replacements` say while one of them applies, the first of
    /// several. A leaf that runs is stopped when one begins to apply, and starts again when
    /// it does not apply any more. To be called before the first tick: checkpoints of the tree
    /// are others than without.
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

/// While a leaf is taken out of its place.
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
    /// The leaf itself was started, and has not ended. In the checkpoint.
    runs: bool,
}

impl<H: Host> AnyLeaf<H> for Replaced<H> {
    fn tick(&mut self, begins: bool, cx: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        let now = cx.now;
        let applies = self.replacements.iter().find(|r| r.applies(now));
        if let Some(answer) = applies.map(|replacement| replacement.answer) {
            // One that takes several ticks to stop is asked again.
            self.runs = self.runs && self.inner.halt(cx, ResetReason::Explicit) == Halt::NotYet;
            return Ok(answer);
        }
        let begins = begins || !self.runs;
        self.runs = false;
        let answer = self.inner.tick(begins, cx)?;
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
