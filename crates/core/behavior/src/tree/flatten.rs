//! Converts a tree as written into the arrays from which it runs.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::check::CONDITION;
use super::error::{Problem, TreeError};
use super::flat::{Check, Code, Counts, Flat, Needs, Op, Policy, Timer};
use super::leaf::{AnyLeaf, Host};
use super::spec::{Abort, Kind, Memory, Modifier, Node, OneShotPolicy, ParallelPolicy};
use super::{MAX_DEPTH, MAX_NODES};
use crate::board::bytes::name_hash;
use crate::board::{Board, In, Scope, Slot};
use crate::graph::{Graph, GraphKind, GraphNode};

/// A tree made ready.
pub(super) struct Ready<H: Host> {
    pub(super) flat: Flat<H>,
    pub(super) graph: Graph,
    /// For records: a hash for each operation.
    pub(super) hashes: Vec<u64>,
}

pub(super) fn flatten<H: Host>(
    name: &str,
    root: Node<H>,
    local: &Board,
) -> Result<Ready<H>, TreeError> {
    let mut builder = Builder {
        flat: Flat::default(),
        graph: Graph {
            kind: GraphKind::Tree,
            name: name.to_owned(),
            nodes: Vec::new(),
            edges: Vec::new(),
        },
        hashes: Vec::new(),
        ids: BTreeSet::new(),
        problems: Vec::new(),
        local,
    };
    // All mistakes are collected: a user corrects a file once, not once per mistake.
    builder.node(root, None, 0);
    if builder.problems.is_empty() {
        Ok(Ready {
            flat: builder.flat,
            graph: builder.graph,
            hashes: builder.hashes,
        })
    } else {
        Err(TreeError {
            tree: name.to_owned(),
            problems: builder.problems,
        })
    }
}

struct Builder<'b, H: Host> {
    flat: Flat<H>,
    graph: Graph,
    hashes: Vec<u64>,
    ids: BTreeSet<u64>,
    problems: Vec<Problem>,
    local: &'b Board,
}

impl<H: Host> Builder<'_, H> {
    fn node(&mut self, node: Node<H>, parent: Option<usize>, depth: usize) {
        // Checked before anything is pushed, so that a hostile file cannot fill memory.
        if self.flat.ops.len() + node.modifiers.len() + 1 > MAX_NODES {
            if !self.problems.contains(&Problem::Many) {
                self.problems.push(Problem::Many);
            }
            return;
        }
        let inner = depth + node.modifiers.len();
        // Bounds the recursion here and in every tick, which has the stack of the task.
        if inner >= MAX_DEPTH {
            self.problems.push(Problem::Deep(node.id));
            return;
        }
        // State is carried over by the hash of the id, so two ids with one hash count as equal.
        if !self.ids.insert(name_hash(&node.id)) {
            self.problems.push(Problem::Duplicate(node.id.clone()));
        }
        let index = self.graph.nodes.len();
        let first = self.flat.ops.len();
        self.graph.nodes.push(picture(&node, parent));
        // Modifiers come before the node, as they are around it: the first is the outermost.
        self.modifiers(&node.id, &node.modifiers);
        self.arity(&node);
        let (code, side) = self.code(&node.id, node.kind, node.children.len());
        self.push(code, side, node.modifiers.is_empty(), &node.id);
        let own = self.flat.ops.len() - 1;
        // Depth first: the children of a node follow it without a gap.
        for child in node.children {
            self.node(child, Some(index), inner + 1);
        }
        let end = u32::try_from(self.flat.ops.len()).unwrap_or(u32::MAX);
        // The node and its modifiers end at the same place.
        for op in self.flat.ops.iter_mut().take(own + 1).skip(first) {
            op.end = end;
        }
        self.finish(own);
    }

    /// Sets the fields that depend on all children.
    fn finish(&mut self, own: usize) {
        let mut starts = Vec::new();
        let (Some(op), mut at) = (self.flat.ops.get(own).copied(), own + 1) else {
            return;
        };
        // `end` leads from child to child, as in the engine.
        while at < op.end as usize {
            starts.push(u32::try_from(at).unwrap_or(u32::MAX));
            at = self.flat.ops.get(at).map_or(usize::MAX, |c| c.end as usize);
        }
        // Most composites have no such check, and skip the search for one in every tick.
        let watches = op.code.is_composite() && starts.iter().any(|c| self.interrupts(*c));
        if let Some(op) = self.flat.ops.get_mut(own) {
            op.watches = watches;
        }
        if op.code == Code::Parallel
            && let Some(policy) = self.flat.policies.get_mut(usize::from(op.side))
            && let Needs::Selected(children) = &mut policy.needs
        {
            // The file counts children; the engine compares statuses of operations.
            for child in children {
                // Out of range only in a tree that is refused for it.
                *child = starts.get(*child as usize).copied().unwrap_or_default();
            }
        }
    }

    /// Whether a modifier of the node that starts there interrupts siblings.
    fn interrupts(&self, start: u32) -> bool {
        let ops = self.flat.ops.iter().skip(start as usize);
        let node = ops.clone().next().map(|op| op.node);
        ops.take_while(|op| Some(op.node) == node).any(|op| {
            let check = self.flat.checks.get(usize::from(op.side));
            op.code == Code::Check
                && check.is_some_and(|c| matches!(c.abort, Abort::LowerPriority | Abort::Both))
        })
    }

    fn modifiers(&mut self, id: &str, modifiers: &[Modifier]) {
        // A modifier has no id. Its state is found by the id of the node, its kind and its
        // number among those of its kind, so other modifiers may be added or removed.
        let mut seen = BTreeMap::new();
        for (nth, modifier) in modifiers.iter().enumerate() {
            let (code, side) = self.modifier(id, *modifier);
            let same: &mut u32 = seen.entry(code.tag()).or_default();
            let key = format!("{id}\n{}\n{same}", code.tag());
            *same += 1;
            self.push(code, side, nth == 0, &key);
        }
    }

    fn modifier(&mut self, id: &str, modifier: Modifier) -> (Code, usize) {
        match modifier {
            Modifier::Repeat {
                count,
                break_on_failure,
            } => {
                let code = Code::Repeat {
                    count,
                    break_on_failure,
                };
                (code, 0)
            }
            Modifier::Retry {
                max,
                reset_on_success,
            } => {
                // One try, and then `max` more.
                let count = if max == 0 { 0 } else { max.saturating_add(1) };
                let budget = !reset_on_success;
                (Code::Retry { count, budget }, 0)
            }
            Modifier::InvertStatus => (Code::Inverter, 0),
            Modifier::ForceStatus(status) => (Code::Force(status), 0),
            Modifier::Delay(seconds) => (Code::Delay, self.timer(id, seconds)),
            Modifier::Timeout(seconds) => (Code::Timeout, self.timer(id, seconds)),
            Modifier::CheckBlackboard { slot, test, abort } => {
                self.slot(id, slot);
                self.flat.checks.push(Check { slot, test, abort });
                (Code::Check, self.flat.checks.len() - 1)
            }
        }
    }

    fn arity(&mut self, node: &Node<H>) {
        let found = node.children.len();
        // Composites may have any number of children.
        let wanted = match &node.kind {
            Kind::Sequence(_)
            | Kind::SequenceWithMemory
            | Kind::Selector(_)
            | Kind::Parallel(_) => found,
            Kind::Wait(_) | Kind::Leaf(_) => 0,
            _ => 1,
        };
        if found != wanted {
            self.problems.push(Problem::Children {
                id: node.id.clone(),
                type_name: node.type_name.clone(),
                found,
                wanted,
            });
        }
    }

    fn code(&mut self, id: &str, kind: Kind<H>, children: usize) -> (Code, usize) {
        let memory = |memory| memory == Memory::Yes;
        match kind {
            Kind::Sequence(m) => (Code::Sequence { memory: memory(m) }, 0),
            Kind::Selector(m) => (Code::Selector { memory: memory(m) }, 0),
            Kind::SequenceWithMemory => (Code::SequenceWithMemory, 0),
            Kind::Parallel(policy) => (Code::Parallel, self.policy(id, policy, children)),
            Kind::Inverter => (Code::Inverter, 0),
            Kind::Converter { from, to } => (Code::Converter { from, to }, 0),
            Kind::PassThrough => (Code::PassThrough, 0),
            Kind::Repeat { count } => {
                let code = Code::Repeat {
                    count: self.count(id, count),
                    break_on_failure: true,
                };
                (code, 0)
            }
            Kind::Retry { count } => {
                let code = Code::Retry {
                    count: self.count(id, count),
                    budget: false,
                };
                (code, 0)
            }
            Kind::Again { count, on_failure } => {
                let count = self.count(id, count);
                (Code::Again { count, on_failure }, 0)
            }
            Kind::OneShot(policy) => {
                let on_failure = policy == OneShotPolicy::OnCompletion;
                (Code::OneShot { on_failure }, 0)
            }
            Kind::Condition(status) => (Code::Condition(status), 0),
            Kind::EternalGuard(guard) => (Code::EternalGuard, self.leaf(guard)),
            Kind::Count => {
                self.flat.counts.push(Counts::default());
                (Code::Count, self.flat.counts.len() - 1)
            }
            Kind::Timeout(seconds) => (Code::Timeout, self.timer(id, seconds)),
            Kind::Wait(seconds) => (Code::Wait, self.timer(id, seconds)),
            Kind::Leaf(leaf) => (Code::Leaf, self.leaf(leaf)),
        }
    }

    fn push(&mut self, code: Code, side: usize, outermost: bool, key: &str) {
        // Indices fit: MAX_NODES is below 65,536.
        let narrow = |index: usize| u16::try_from(index).unwrap_or(u16::MAX);
        let mut op = Op::new(code, narrow(self.graph.nodes.len() - 1), outermost);
        op.side = narrow(side);
        self.flat.ops.push(op);
        self.hashes.push(name_hash(key));
    }

    fn leaf(&mut self, leaf: Box<dyn AnyLeaf<H>>) -> usize {
        self.flat.leaves.push(leaf);
        self.flat.leaves.len() - 1
    }

    fn count(&mut self, id: &str, count: Option<u32>) -> u32 {
        if count == Some(0) {
            self.problems.push(Problem::Zero(id.to_owned()));
        }
        count.unwrap_or(0)
    }

    fn timer(&mut self, id: &str, seconds: In<f64>) -> usize {
        match seconds {
            // A time from a key is checked when the timer starts.
            In::Literal(value) if !(value >= 0.0 && value.is_finite()) => {
                self.problems.push(Problem::Seconds {
                    id: id.to_owned(),
                    seconds: value.to_string(),
                });
            }
            In::Literal(_) => {}
            In::Key(slot) => self.slot(id, slot),
        }
        self.flat.timers.push(Timer {
            seconds,
            deadline: Duration::ZERO,
        });
        self.flat.timers.len() - 1
    }

    // Keys of the shared board are not known here: other trees declare them, too.
    fn slot(&mut self, id: &str, slot: Slot) {
        if slot.scope == Scope::Local && slot.index >= self.local.len() {
            self.problems.push(Problem::Key(id.to_owned()));
        }
    }

    fn policy(&mut self, id: &str, policy: ParallelPolicy, children: usize) -> usize {
        let (needs, synchronise) = match policy {
            ParallelPolicy::All { synchronise } => (Needs::All, synchronise),
            ParallelPolicy::One => (Needs::One, false),
            ParallelPolicy::Count {
                successes,
                failures,
            } => {
                let needs = Needs::Count {
                    successes,
                    failures,
                };
                // As in BehaviorTree.CPP, a finished child is not ticked again.
                (needs, true)
            }
            ParallelPolicy::Finish { failures } => (Needs::Finish { failures }, true),
            ParallelPolicy::Selected {
                children: selected,
                synchronise,
            } => {
                self.selected(id, &selected, children);
                let narrow = |index: &usize| u32::try_from(*index).unwrap_or(u32::MAX);
                (
                    Needs::Selected(selected.iter().map(narrow).collect()),
                    synchronise,
                )
            }
        };
        self.flat.policies.push(Policy { synchronise, needs });
        self.flat.policies.len() - 1
    }

    fn selected(&mut self, id: &str, selected: &[usize], children: usize) {
        if selected.is_empty() {
            self.problems.push(Problem::NoneSelected(id.to_owned()));
        }
        for index in selected.iter().copied().filter(|i| *i >= children) {
            self.problems.push(Problem::Selected {
                id: id.to_owned(),
                index,
                children,
            });
        }
    }
}

/// The type; for a condition also the word, since its type may not contain it.
fn shown_kind<H: Host>(node: &Node<H>) -> String {
    match node.type_name.as_str() {
        type_name if node.condition && type_name != CONDITION => format!("{CONDITION} {type_name}"),
        type_name => type_name.to_owned(),
    }
}

fn picture<H: Host>(node: &Node<H>, parent: Option<usize>) -> GraphNode {
    let modifiers: Vec<&str> = node.modifiers.iter().map(Modifier::name).collect();
    let parts = [node.detail.as_str(), &modifiers.join(", ")];
    let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    GraphNode {
        id: node.id.clone(),
        kind: shown_kind(node),
        name: node.name.clone(),
        parent,
        detail: parts.join("; "),
    }
}
