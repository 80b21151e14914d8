//! A leaf of the user's own in a tree in code, as in docs/task-in-rust.md.

use behavior::Status;
use behavior::board::{Board, Fault};
use behavior::tree::{Cx, Leaf, Node, Tree};
use cell_model::{Cell, Data};
use ipc_types::{Wire as _, WorldState};
use robocell_skills::{Setup, Station, World};
use robocell_task::{Job, Observation, Output, PolicyTime};

struct Announce {
    object: usize,
}

impl Leaf<Station> for Announce {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Station>) -> Result<Status, Fault> {
        let name = cx.world.setup.object_name(self.object);
        cx.world.out.log(format_args!("[next] {name}"));
        Ok(Status::Success)
    }
}

#[test]
fn a_leaf_of_the_users_own_sees_the_cell_and_logs() {
    let cell = Cell::load(&Data::checkout(), "cube", 1, None).unwrap();
    let setup = Setup::new(&cell, []);
    let leaf = Node::leaf("announce", "leaf", Announce { object: 0 });
    let mut tree = Tree::new("one", leaf, Board::new()).unwrap();
    let state = Box::new(WorldState::zeroed());
    let observation = Observation::new(&state, &[], PolicyTime::default());
    let (mut job, mut out) = (Job::new(1), Output::default());
    let mut world = World::new(&setup, &observation, &mut job, &mut out, 0);
    let status = tree.tick(std::time::Duration::ZERO, &mut Board::new(), &mut world);
    assert_eq!(status, Status::Success);
    let (mut decision, mut trace) = (ipc_types::Decision::zeroed(), Vec::new());
    out.finish(1, &mut decision, &mut trace);
    let said = trace.iter().any(|line| line.text.as_str() == "[next] cube");
    assert!(said, "{trace:?}");
    // The docs quote the leaf.
    let docs = std::fs::read_to_string(Data::checkout_dir().join("docs/task-in-rust.md")).unwrap();
    let own = include_str!("own_leaf.rs");
    let leaf = own.split("struct Announce").nth(1).unwrap();
    let leaf = leaf.split("\n#[test]").next().unwrap().trim_end();
    assert!(
        docs.contains(leaf),
        "docs/task-in-rust.md shows another leaf"
    );
}
