//! A host whose leaves answer from scripts and tell what was done to them.

#![allow(dead_code, reason = "each test file uses a part of it")]
use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::status::{NodeStatus, ResetReason, Status};
use behavior::tree::{Cx, Halt, Host, Leaf, Node, Tree};

/// The world is a list of what happened.
pub(crate) struct Bench;

impl Host for Bench {
    type World<'w> = Vec<String>;
}

/// Answers letter by letter, the last forever, and takes `halts` ticks more
/// to stop.
pub(crate) struct Act {
    pub(crate) name: &'static str,
    pub(crate) script: &'static str,
    pub(crate) halts: u32,
}

impl Leaf<Bench> for Act {
    /// Answers given, calls to halt.
    type State = (u32, u32);

    fn start(&self, state: &mut (u32, u32), cx: &mut Cx<'_, '_, Bench>) -> Result<(), Fault> {
        state.1 = 0;
        cx.world.push(format!("{} starts", self.name));
        Ok(())
    }

    fn tick(&self, state: &mut (u32, u32), cx: &mut Cx<'_, '_, Bench>) -> Result<Status, Fault> {
        let letter = self.script.chars().nth(state.0 as usize);
        let letter = letter.or(self.script.chars().last()).unwrap_or('-');
        state.0 += 1;
        cx.world.push(format!("{} {letter}", self.name));
        let answer = NodeStatus::from_letter(letter).and_then(NodeStatus::answer);
        answer.ok_or(Fault::Node("no such letter"))
    }

    fn halt(
        &self,
        state: &mut (u32, u32),
        cx: &mut Cx<'_, '_, Bench>,
        reason: ResetReason,
    ) -> Halt {
        cx.world
            .push(format!("{} halts: {}", self.name, reason.name()));
        state.1 += 1;
        if state.1 > self.halts {
            Halt::Done
        } else {
            Halt::NotYet
        }
    }
}

/// The leaf `name` with its script.
pub(crate) fn act(name: &'static str, script: &'static str) -> Node<Bench> {
    slow(name, script, 0)
}

/// As [`act`]; needs `halts` ticks more to stop.
pub(crate) fn slow(name: &'static str, script: &'static str, halts: u32) -> Node<Bench> {
    let leaf = Act {
        name,
        script,
        halts,
    };
    Node::leaf(name, "Act", leaf)
}

/// A tree with the boards and the world it needs.
pub(crate) struct Stand {
    pub(crate) tree: Tree<Bench>,
    pub(crate) shared: Board,
    pub(crate) log: Vec<String>,
}

impl Stand {
    pub(crate) fn new(root: Node<Bench>, local: Board) -> Self {
        Self {
            tree: Tree::new("stand", root, local).unwrap(),
            shared: Board::new(),
            log: Vec::new(),
        }
    }

    /// Ticks at that time in milliseconds; the answer, and what was done.
    pub(crate) fn tick(&mut self, ms: u64) -> (char, String) {
        self.log.clear();
        let now = Duration::from_millis(ms);
        let answer = self.tree.tick(now, &mut self.shared, &mut self.log);
        (answer.letter(), self.log.join(", "))
    }

    pub(crate) fn answer(&mut self, ms: u64) -> char {
        self.tick(ms).0
    }

    /// Statuses of all nodes as letters.
    pub(crate) fn letters(&self) -> String {
        let mut statuses = Vec::new();
        self.tree.statuses(&mut statuses);
        statuses.into_iter().map(NodeStatus::letter).collect()
    }

    /// Throws the tree away and continues with one made by `make`.
    pub(crate) fn kill(&mut self, make: impl FnOnce() -> Self) {
        let mut record = Vec::new();
        self.tree.save(&mut record);
        let mut next = make();
        let carried = next.tree.restore(&record).unwrap();
        assert_eq!(carried.lost, 0);
        self.tree = next.tree;
    }
}
