//! The 27 nodes of a pick-and-place tree, ten ticks a phase, with leaves that
//! do almost nothing: the time is the cost of the engine.

use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::status::Status;
use behavior::tree::{Cx, Host, Leaf, Memory, Node, Tree, TreeError};

const TICKS_A_PHASE: u32 = 10;

/// Its world counts the calls of leaves.
pub(crate) struct Bench;

impl Host for Bench {
    type World<'w> = u64;
}

/// A condition that does not hold.
struct Never;

impl Leaf<Bench> for Never {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Bench>) -> Result<Status, Fault> {
        *cx.world += 1;
        Ok(Status::Failure)
    }
}

/// Runs for so many ticks.
struct Phase(u32);

impl Leaf<Bench> for Phase {
    type State = u32;

    fn start(&self, ticks: &mut u32, _: &mut Cx<'_, '_, Bench>) -> Result<(), Fault> {
        *ticks = 0;
        Ok(())
    }

    fn tick(&self, ticks: &mut u32, cx: &mut Cx<'_, '_, Bench>) -> Result<Status, Fault> {
        *cx.world += 1;
        *ticks += 1;
        Ok(if *ticks < self.0 {
            Status::Running
        } else {
            Status::Success
        })
    }
}

fn never(id: &str) -> Node<Bench> {
    Node::leaf(id, "condition", Never)
}

fn phases(ids: &[&str]) -> Vec<Node<Bench>> {
    let phase = |id: &&str| Node::leaf(id, "phase", Phase(TICKS_A_PHASE));
    ids.iter().map(phase).collect()
}

fn action(id: &str) -> Node<Bench> {
    Node::leaf(id, "action", Phase(1))
}

fn sequence(id: &str, children: Vec<Node<Bench>>) -> Node<Bench> {
    Node::sequence(id, Memory::Yes, children)
}

/// The tree, with the priorities of a stacking job from left to right: done,
/// two recoveries, the normal sequence.
///
/// # Errors
/// None, as long as the tree is valid.
pub(crate) fn pick_and_place() -> Result<Tree<Bench>, TreeError> {
    let dropped = sequence(
        "drop recovery",
        vec![never("dropped?"), action("clear dropped")],
    );
    let mut broken = vec![never("broken?")];
    broken.extend(phases(&[
        "lift back",
        "transport back",
        "lower back",
        "release back",
    ]));
    broken.extend(phases(&["retract back"]));
    broken.push(action("clear holding back"));
    let mut place = phases(&["lift", "transport", "lower", "release", "retract"]);
    place.push(action("clear holding"));
    let mut normal = vec![action("select")];
    normal.push(sequence("pickup", phases(&["pre-grasp", "approach"])));
    normal.extend(phases(&["grasp"]));
    normal.push(action("mark holding"));
    normal.push(sequence("place", place));
    let branches = vec![
        never("all stacked?"),
        dropped,
        sequence("stack recovery", broken),
        sequence("normal", normal),
    ];
    Tree::new(
        "pick-and-place",
        Node::selector("root", Memory::No, branches),
        Board::new(),
    )
}

/// Ticks it so many times; returns the number of calls of leaves.
pub(crate) fn run(tree: &mut Tree<Bench>, ticks: u64) -> u64 {
    let (mut shared, mut world) = (Board::new(), 0);
    for tick in 0..ticks {
        tree.tick(Duration::from_millis(tick), &mut shared, &mut world);
    }
    world
}
