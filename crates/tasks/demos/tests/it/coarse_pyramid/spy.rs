//! The policy of the pyramid with a window: the content of its shared board after each
//! decision.

use std::sync::{Arc, Mutex};

use behavior::board::Board;
use behavior::{Graph, NodeStatus, Value};
use cell_model::Cell;
use demos::pyramid::numbers::PyramidTask;
use ipc_types::Text;
use robocell_skills::files::TreePolicy;
use robocell_task::{AnyPolicy, Job, Observation, Output};

use super::choice::ARMS;

pub(crate) const NAMES: [&str; ARMS] = ["left", "right"];

/// Relation of an arm to a cube, on the shared board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Word {
    Available,
    Reserved(usize),
    Carried(usize),
    Placed(usize),
}

/// The data seen through the window.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Seen {
    /// Arm that owns the centre.
    pub(crate) owner: Option<usize>,
    /// By cube.
    pub(crate) words: Vec<Word>,
    /// By arm: bits of the cubes of its stack.
    pub(crate) placed: [u64; ARMS],
    pub(crate) recovery: [bool; ARMS],
    /// By arm: the leaf that runs, and whether the tree is through.
    pub(crate) leaf: [Option<usize>; ARMS],
    pub(crate) finished: [bool; ARMS],
}

/// See the module.
pub(crate) struct Spy {
    json: TreePolicy,
    cubes: Vec<String>,
    /// By arm and node: whether it is a leaf.
    leaves: Vec<Vec<bool>>,
    window: Arc<Mutex<Seen>>,
}

impl Spy {
    pub(crate) fn new(cell: &Cell, cubes: &[&str]) -> (Self, Arc<Mutex<Seen>>) {
        let task: PyramidTask = cell.task.read().unwrap();
        let json = demos::pyramid::policy(&task, cell).unwrap();
        let is_leaf = |graph: &Graph, node| graph.nodes.iter().all(|n| n.parent != Some(node));
        let leaves = json.describe("json").into_iter().map(|graph| {
            let nodes = 0..graph.nodes.len();
            nodes.map(|node| is_leaf(&graph, node)).collect()
        });
        let window = Arc::new(Mutex::new(Seen::default()));
        let spy = Self {
            leaves: leaves.collect(),
            json,
            cubes: cubes.iter().map(|c| format!("cube_state:{c}")).collect(),
            window: Arc::clone(&window),
        };
        (spy, window)
    }

    fn look(&self) {
        let board = self.json.board("shared").unwrap();
        let mut seen = Seen {
            owner: arm_named(&text(board, "center_owner")),
            words: self.cubes.iter().map(|key| word(board, key)).collect(),
            ..Seen::default()
        };
        let mut statuses = Vec::new();
        for (arm, name) in NAMES.iter().enumerate() {
            if let Some(Value::Set(set)) = value(board, &format!("placed:{name}")) {
                seen.placed[arm] = set.items().map(|cube| 1 << cube).sum();
            }
            seen.recovery[arm] =
                value(board, &format!("recovery_requested:{name}")) == Some(Value::Bool(true));
            statuses.clear();
            self.json.statuses(arm, &mut statuses);
            seen.finished[arm] = statuses.first() == Some(&NodeStatus::Success);
            let runs = |(node, is_leaf): (usize, &bool)| {
                (*is_leaf && statuses[node] == NodeStatus::Running).then_some(node)
            };
            seen.leaf[arm] = self.leaves[arm].iter().enumerate().find_map(runs);
        }
        *self.window.lock().unwrap() = seen;
    }
}

fn value(board: &Board, key: &str) -> Option<Value> {
    board.value(board.index(key)?)
}

fn text(board: &Board, key: &str) -> String {
    match value(board, key) {
        Some(Value::Text(text)) => text.as_str().to_owned(),
        other => panic!("{key} is {other:?}"),
    }
}

fn arm_named(name: &str) -> Option<usize> {
    assert!(name.is_empty() || NAMES.contains(&name), "no arm '{name}'");
    NAMES.iter().position(|n| *n == name)
}

fn word(board: &Board, key: &str) -> Word {
    let text = text(board, key);
    let (verb, name) = text.split_once(':').unwrap_or((&text, ""));
    match (verb, arm_named(name)) {
        ("available", None) => Word::Available,
        ("reserved", Some(arm)) => Word::Reserved(arm),
        ("carried", Some(arm)) => Word::Carried(arm),
        ("placed", Some(arm)) => Word::Placed(arm),
        _ => panic!("{key} is '{text}'"),
    }
}

impl AnyPolicy for Spy {
    fn reset(&mut self) {
        self.json.reset();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.json.decide(observation, job, out);
        self.look();
    }

    fn phase(&self) -> Text<32> {
        self.json.phase()
    }

    fn describe(&self, name: &str) -> Vec<Graph> {
        self.json.describe(name)
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        self.json.statuses(graph, out);
    }

    fn save(&self) -> Vec<u8> {
        self.json.save()
    }

    fn restore(&mut self, record: &[u8]) -> Result<(), bincode::Error> {
        self.json.restore(record)
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.json.reconcile(observation, job, out);
    }
}
