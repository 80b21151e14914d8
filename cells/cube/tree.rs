//! Put the cube on the mark, as a tree in code.

use behavior::board::Board;
use behavior::tree::{Memory, Node, Tree, TreeError};
use robocell_skills::{Close, Condition, MoveTo, Open, Skill, SkillLeaf, Station};

fn skill(id: &str, skill: impl Skill) -> Node<Station> {
    Node::leaf(id, "skill", SkillLeaf(skill))
}

fn condition(id: &str, condition: Condition) -> Node<Station> {
    Node::leaf(id, "condition", condition)
}

/// The tree. A selector without memory asks its children from the left at every
/// tick; skills that have nothing to do succeed at once.
pub(crate) fn tree(cube: usize, mark: usize) -> Result<Tree<Station>, TreeError> {
    let on_mark = Condition::At {
        object: cube,
        place: mark,
        tolerance_m: 0.02,
    };
    let leave = Node::sequence(
        "leave",
        Memory::Yes,
        vec![
            skill("let_go", Open),
            skill("retract", MoveTo::object(cube, 0.1)),
        ],
    );
    let finish = Node::sequence(
        "finish",
        Memory::No,
        vec![condition("on_mark", on_mark), leave],
    );
    let bring = Node::sequence(
        "bring",
        Memory::Yes,
        vec![
            skill("lift", MoveTo::up(0.1).holding(cube)),
            skill("carry", MoveTo::place(cube, mark, 0.1)),
            skill("lower", MoveTo::place(cube, mark, 0.0)),
            skill("release", Open),
        ],
    );
    let deliver = Node::sequence(
        "deliver",
        Memory::No,
        vec![condition("holding", Condition::Holding(Some(cube))), bring],
    );
    let fetch = Node::sequence(
        "fetch",
        Memory::Yes,
        vec![
            skill("above", MoveTo::object(cube, 0.1)),
            skill("down", MoveTo::object(cube, 0.0)),
            skill("grasp", Close { object: Some(cube) }),
        ],
    );
    let job = Node::selector("job", Memory::No, vec![finish, deliver, fetch]);
    Tree::new("cube", job, Board::new())
}
