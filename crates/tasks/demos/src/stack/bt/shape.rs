//! The tree: 26 nodes, recovery to the left of the normal sequence.

use behavior::Status;
use behavior::board::Board;
use behavior::tree::check::CONDITION;
use behavior::tree::{Memory, Node, Tree, TreeError};

use super::leaves::{
    Once, PhaseLeaf, all_stacked, clear_dropped, clear_transfer, cube_dropped, select_next_cube,
    stack_below_broken,
};
use super::{StackHost, StackWorld};
use crate::stack::Phase;

type Part = Node<StackHost>;

/// The tree before its first tick. Its root, a selector without memory, ticks its children from
/// the left in every tick.
///
/// # Errors
/// Returns [`TreeError`] for a mistake in this function.
pub fn tree() -> Result<Tree<StackHost>, TreeError> {
    // Drop recovery before stack recovery: a cube that is no longer held cannot be taken back.
    let drop_recovery = vec![
        condition("CubeDropped", cube_dropped),
        once("ClearDropped", clear_dropped),
    ];
    let mut stack_recovery = vec![condition("StackBelowBroken", stack_below_broken)];
    let back = [
        "LiftBack",
        "TransportBack",
        "LowerBack",
        "ReleaseBack",
        "RetractBack",
    ];
    stack_recovery.extend(set_down(back, true));
    stack_recovery.push(once("ClearReturned", clear_transfer));
    let pickup = vec![
        phase("PreGrasp", Phase::PreGrasp, false),
        phase("Approach", Phase::Approach, false),
    ];
    let there = ["Lift", "Transport", "Lower", "Release", "Retract"];
    let mut place = set_down(there, false);
    place.push(once("ClearHolding", clear_transfer));
    let normal = vec![
        once("SelectNextCube", select_next_cube),
        Node::sequence("Pickup", Memory::Yes, pickup),
        phase("Grasp", Phase::Grasp, false),
        Node::sequence("Place", Memory::Yes, place),
    ];
    // Each branch has memory, the root has none: a recovery preempts at any tick, but a branch
    // that runs continues with its current child instead of asking its conditions again.
    let branches = vec![
        condition("AllStacked", all_stacked),
        Node::sequence("DropRecovery", Memory::Yes, drop_recovery),
        Node::sequence("StackRecovery", Memory::Yes, stack_recovery),
        Node::sequence("Normal", Memory::Yes, normal),
    ];
    let root = Node::selector("Root", Memory::No, branches);
    Tree::new("bt", root, Board::new())
}

/// The five phases from the lift to the open, free gripper.
fn set_down(names: [&'static str; 5], back: bool) -> Vec<Part> {
    let phases = Phase::RING.into_iter().skip(Phase::Lift as usize);
    let steps = names.into_iter().zip(phases);
    steps.map(|(name, it)| phase(name, it, back)).collect()
}

fn phase(name: &'static str, phase: Phase, back: bool) -> Part {
    let mut node = Node::leaf(name, "action", PhaseLeaf { name, phase, back });
    phase.name().clone_into(&mut node.detail);
    node
}

fn condition(id: &str, leaf: fn(&mut StackWorld<'_>) -> Status) -> Part {
    Node::leaf(id, CONDITION, Once(leaf))
}

fn once(id: &str, leaf: fn(&mut StackWorld<'_>) -> Status) -> Part {
    Node::leaf(id, "action", Once(leaf))
}
