//! The policy of trees, built from its files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Library, Tree};
use behavior::{Graph, Status, Str, Value};
use cell_model::Cell;
use robocell_task::settings::behaviour_text;
use robocell_task::tree_trace::{KeyWatch, TreeTrace};
use robocell_task::{AnyPolicy as _, SetupError};

use super::{ArmTree, SharedBoard, TreeJob, TreePolicy, TreeSource};
use crate::condition::PLACE_TOLERANCE_M;
use crate::files::nested;
use crate::files::phases::{self, Shown};
use crate::setup::Setup;
use crate::shared::ROBOT;
use crate::shared::lease::Zones;
use crate::skill::Station;
use crate::world::ArmMemory;

impl TreePolicy {
    /// A policy with one tree in code, for the first arm.
    pub(in crate::files) fn of_tree(setup: &Arc<Setup>, tree: Tree<Station>) -> Self {
        let mut policy = Self::empty(Arc::clone(setup), false, PLACE_TOLERANCE_M);
        let board = policy.board_named("shared");
        let graph = tree.graph();
        policy.add(tree, graph, board);
        policy.begin();
        policy
    }

    fn empty(setup: Arc<Setup>, once: bool, tolerance_m: f64) -> Self {
        Self {
            setup,
            once,
            is_still_done: None,
            tolerance_m,
            arms: Vec::new(),
            boards: Vec::new(),
            shown: Shown::default(),
            initial: Vec::new(),
            resumed: false,
            lost: 0,
        }
    }

    fn add(&mut self, tree: Tree<Station>, graph: Graph, board: usize) {
        let arm = self.setup.arms.get(self.arms.len());
        let is_absent = arm.is_some_and(|arm| arm.is_absent);
        self.arms.push(ArmTree {
            is_absent,
            trace: TreeTrace::new(&graph),
            phases: phases::names(&graph.name, &graph),
            tree,
            graph,
            board,
            memory: ArmMemory::default(),
            status: Status::Running,
            failed: None,
        });
    }

    pub(super) fn new(
        job: TreeJob,
        cell: &Cell,
        sources: &[TreeSource],
    ) -> Result<Self, SetupError> {
        // Machines of files are a node type of every tree, also of jobs with a library of their
        // own.
        let machines = nested::node_type(&job.setup, Some(&cell.data), &[]);
        let library = job.library.with(machines);
        let mut policy = Self::empty(job.setup, job.once, job.tolerance_m);
        policy.is_still_done = job.is_still_done;
        let names: Vec<&str> = cell.arms.iter().map(|arm| arm.name.as_str()).collect();
        for (name, source) in names.iter().zip(sources) {
            let board = policy.board_named(&source.board);
            let Some(shared) = policy.boards.get_mut(board) else {
                continue;
            };
            let mut constants = job.constants.clone();
            let robot = Value::Text(Str::new(name).unwrap_or_default());
            constants.insert(ROBOT.to_owned(), robot);
            let file = &source.file;
            let tree = load(cell, file, &library, &constants, &mut shared.board)?;
            let mut graph = tree.graph();
            // With one arm the graph keeps the name of its file.
            if names.len() > 1 {
                (*name).clone_into(&mut graph.name);
            }
            policy.add(tree, graph, board);
        }
        policy.begin();
        // A larger checkpoint would not be kept; the job and the goals need the other half.
        let allowed = robocell_task::checkpoint::MAX_BYTES / 2;
        let found = policy.initial.len();
        if found == 0 || found > allowed {
            let problem = format!(
                "the trees need {found} bytes in the checkpoint, at most {allowed} are allowed; use \
                 fewer nodes"
            );
            return Err(SetupError::new(cell, problem));
        }
        Ok(policy)
    }

    /// Completes the policy after the last tree was added.
    fn begin(&mut self) {
        for shared in &mut self.boards {
            shared.zones = Zones::of(&shared.board);
        }
        self.shown = Shown::new(self.arms.len());
        // Saved with all trees: a reset restores these bytes.
        self.initial = self.save();
    }

    fn board_named(&mut self, name: &str) -> usize {
        let known = self.boards.iter().position(|known| known.name == name);
        known.unwrap_or_else(|| {
            self.boards.push(SharedBoard {
                name: name.to_owned(),
                board: Board::new(),
                zones: Zones::default(),
                watch: KeyWatch::default(),
            });
            self.boards.len() - 1
        })
    }
}

/// Loads the tree in `file`, beside the cell file, and adds its keys to `shared`.
fn load(
    cell: &Cell,
    file: &str,
    library: &Library<Station>,
    constants: &BTreeMap<String, Value>,
    shared: &mut Board,
) -> Result<Tree<Station>, SetupError> {
    let text = behaviour_text(cell, file)?;
    let include = |name: &str| {
        let text = cell.read(name).map(Cow::into_owned);
        text.map_err(|error| error.to_string())
    };
    let file = cell.name_of(file);
    let source = Source {
        file: &file,
        text: &text,
        include: &include,
    };
    descriptor::load(&source, library, constants, shared)
        .map_err(|errors| SetupError::in_file(errors.to_string()))
}
