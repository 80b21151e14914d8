//! Trees in files, one for each arm. Trees that name the same blackboard share it.

mod checkpoint;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Library, Tree};
use behavior::{Graph, NodeStatus, Status, Str, Value};
use cell_model::Cell;
use cell_model::cells::replace::Replace;
use ipc_types::Text;
use robocell_task::replaced::replace_leaves;
use robocell_task::settings::behaviour_text;
use robocell_task::tree_trace::{KeyWatch, TreeTrace};
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError, TraceEvent};

use super::phases::{self, Phase, Shown};
use super::{nested, parts};
use crate::ability;
use crate::condition::PLACE_TOLERANCE_M;
use crate::nodes;
use crate::setup::Setup;
use crate::shared::lease::Zones;
use crate::shared::{self, ROBOT};
use crate::skill::Station;
use crate::world::{ArmMemory, World};

/// The source of an arm's tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeSource {
    /// File beside the cell file.
    pub file: String,
    /// Name of its shared blackboard.
    pub board: String,
}

/// A job that runs trees.
pub struct TreeJob {
    /// The cell.
    pub setup: Arc<Setup>,
    /// The node types.
    pub library: Library<Station>,
    /// Constants of every tree. The constant `robot`, the name of the tree's arm, is added.
    pub constants: BTreeMap<String, Value>,
    /// Whether an arm has done its part once its tree succeeded: it is not ticked again.
    pub once: bool,
    /// Whether the work of an arm is still done, for [`Self::once`]: until all arms have done
    /// their part, a tree whose work was undone is ticked again.
    pub is_still_done: Option<StillDone>,
    /// An object nearer than this to its slot of a place is in it (m).
    pub tolerance_m: f64,
}

/// Checks whether the work of [`World::arm`] is done.
pub type StillDone = Box<dyn Fn(&World<'_>) -> bool + Send + Sync>;

impl TreeJob {
    /// A job with the skills as node types, whose trees are ticked again after success.
    pub fn new(setup: Arc<Setup>) -> Self {
        Self {
            library: nodes::library(&setup),
            setup,
            constants: BTreeMap::new(),
            once: false,
            is_still_done: None,
            tolerance_m: PLACE_TOLERANCE_M,
        }
    }

    /// The policy of the trees in `sources`, one for each arm of the cell.
    ///
    /// # Errors
    /// Returns a [`SetupError`] with all errors of a file, or for trees that are too large for
    /// a checkpoint.
    pub fn policy(self, cell: &Cell, sources: &[TreeSource]) -> Result<TreePolicy, SetupError> {
        TreePolicy::new(self, cell, sources)
    }
}

/// The policy of trees in files.
pub struct TreePolicy {
    setup: Arc<Setup>,
    once: bool,
    is_still_done: Option<StillDone>,
    tolerance_m: f64,
    arms: Vec<ArmTree>,
    boards: Vec<SharedBoard>,
    /// The phase that is shown, with several arms.
    shown: Shown,
    initial: Vec<u8>,
    resumed: bool,
    /// Number of nodes and keys of the last checkpoint that are not in the files.
    lost: usize,
}

struct ArmTree {
    tree: Tree<Station>,
    graph: Graph,
    board: usize,
    /// Phase by node, with several arms.
    phases: Vec<Phase>,
    trace: TreeTrace,
    memory: ArmMemory,
    /// Its result in the decision before.
    status: Status,
    /// The node whose failure was reported last.
    failed: Option<usize>,
}

struct SharedBoard {
    name: String,
    board: Board,
    zones: Zones,
    watch: KeyWatch,
}

impl TreePolicy {
    /// A policy with one tree in code, for the first arm.
    pub(super) fn of_tree(setup: &Arc<Setup>, tree: Tree<Station>) -> Self {
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
        self.arms.push(ArmTree {
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

    fn new(job: TreeJob, cell: &Cell, sources: &[TreeSource]) -> Result<Self, SetupError> {
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

    /// A shared blackboard, by its name in the cell file.
    pub fn board(&self, name: &str) -> Option<&Board> {
        let shared = self.boards.iter().find(|known| known.name == name);
        shared.map(|shared| &shared.board)
    }

    /// Renews the leases of zones whose owner is working.
    fn watch_zones(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let Self {
            setup,
            once,
            arms,
            boards,
            ..
        } = self;
        let now = observation.time().seconds();
        let mut alive = [false; ipc_types::MAX_ARMS];
        for (arm, (alive, tree)) in alive.iter_mut().zip(&*arms).enumerate() {
            let world = World::new(setup, observation, job, out, arm);
            // An arm that has done its part is not ticked again and could not release a zone
            // itself.
            *alive = world.is_alive() && !(*once && tree.status == Status::Success);
        }
        let works = |owner: &str| {
            let arm = setup.arm(owner).and_then(|arm| alive.get(arm));
            arm == Some(&true)
        };
        for SharedBoard { board, zones, .. } in boards {
            zones.watch(board, now, works, |zone, owner| {
                out.event(
                    TraceEvent::Recover,
                    format_args!("[zone] {owner} does not answer, zone '{zone}' is free"),
                );
            });
        }
    }

    fn tick(&mut self, arm: usize, world: &mut World<'_>) {
        let Some(it) = self.arms.get_mut(arm) else {
            return;
        };
        let Some(shared) = self.boards.get_mut(it.board) else {
            return;
        };
        let now = Duration::from_millis(world.now().ticks());
        let mut status = it.tree.tick(now, &mut shared.board, world);
        // Decided by the observation: a tree that succeeded while its object fell has not done
        // its part.
        if status == Status::Success && was_undone(self.is_still_done.as_ref(), world) {
            status = Status::Running;
        }
        it.trace.tick(&it.tree, arm, world.out);
        let tip = it.tree.tip();
        self.shown.note(arm, tip);
        // A tree between two runs holds no zone: a failed one would block the other arm until
        // it retries.
        if status != Status::Running {
            shared.zones.leave(&mut shared.board, world.arm_name());
        }
        let name = &it.graph.name;
        let out = &mut *world.out;
        if status == Status::Success && it.status != Status::Success {
            out.event(TraceEvent::Done, format_args!("[done] {name}"));
            it.failed = None;
        }
        // Repeated failures at the same node are reported once: a hundred a second would fill
        // the log.
        if status == Status::Failure && it.failed != tip {
            let node = tip.and_then(|tip| it.graph.nodes.get(tip));
            let node = node.map_or("?", |node| node.name.as_str());
            out.log(format_args!(
                "[retry] {name}: '{node}' failed; the tree starts again"
            ));
            it.failed = tip;
        }
        it.status = status;
    }

    fn is_done(&self) -> bool {
        self.arms.iter().all(|arm| arm.status == Status::Success)
    }

    /// Whether there are several arms. With one arm a goal is a phase, and the job has the held
    /// object.
    fn is_of_several(&self) -> bool {
        self.arms.len() > 1
    }
}

/// Whether an arm whose tree succeeded has to work again: its work was undone before all arms
/// had done their part.
fn was_undone(is_still_done: Option<&StillDone>, world: &mut World<'_>) -> bool {
    if is_still_done.is_none_or(|is| is(world)) {
        return false;
    }
    let arm = world.arm_name();
    world.out.log(format_args!(
        "[retry] {arm}: what it did was undone; the tree starts again"
    ));
    true
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

impl AnyPolicy for TreePolicy {
    fn warnings(&self, cell: &Cell) -> Vec<String> {
        let mut warnings = parts::warnings(self.arms.iter().map(|arm| &arm.tree));
        warnings.extend(ability::far_picks(cell, &self.setup));
        warnings
    }

    fn replace(&mut self, rules: &[Replace]) -> Result<(), String> {
        // Other leaves have other states, so the checkpoint of the start is written again.
        replace_leaves(self.arms.iter_mut().map(|arm| &mut arm.tree), rules)?;
        self.initial = self.save();
        Ok(())
    }

    fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It cannot fail: this policy wrote the bytes.
        let _taken = self.take(&initial).is_ok();
        self.initial = initial;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let resumed = std::mem::take(&mut self.resumed);
        // Before the trees: a zone whose owner is gone has to be free in this decision.
        self.watch_zones(observation, job, out);
        let lost = std::mem::take(&mut self.lost);
        if lost > 0 {
            let why =
                format_args!("[task] {lost} nodes or keys of the checkpoint are not in the files");
            out.lifecycle(TraceEvent::None, why);
        }
        // Taken before the loop: within one decision all arms are judged by the same state.
        let all_done = self.is_done();
        for arm in 0..self.arms.len() {
            let Some((mut memory, status)) = self.arms.get(arm).map(|it| (it.memory, it.status))
            else {
                continue;
            };
            let mut world = World::new(&setup, observation, job, out, arm);
            world.resumed = resumed;
            if self.is_of_several() {
                world.memory = Some(&mut memory);
            }
            let is_over = self.once && status == Status::Success;
            if !is_over || (!all_done && was_undone(self.is_still_done.as_ref(), &mut world)) {
                self.tick(arm, &mut world);
            }
            // Also for an arm whose tree was not ticked: it keeps its target, and a drop
            // counts.
            world.finish();
            if let Some(it) = self.arms.get_mut(arm) {
                it.memory = memory;
            }
        }
        for shared in &mut self.boards {
            shared.watch.changes(&shared.board, &shared.name, 0, out);
        }
        let mut world = World::new(&setup, observation, job, out, 0);
        world.report_within(self.is_done(), self.tolerance_m);
        // Counted for scripts: two entries of the same phase have the same name.
        if self.shown.advance() && self.is_of_several() {
            job.counters.phase_entry += 1;
        }
        out.phase = self.phase();
    }

    /// With one arm the name of the node that gave the result.
    fn phase(&self) -> Text<32> {
        if self.is_of_several() {
            let shown = self.shown.current();
            let phase = shown.and_then(|(arm, node)| self.arms.get(arm)?.phases.get(node));
            return phase.copied().unwrap_or(Text::EMPTY);
        }
        let arm = self.arms.first();
        let node = arm.and_then(|arm| arm.graph.nodes.get(arm.tree.tip()?));
        Text::new(node.map_or("", |node| node.name.as_str()))
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        self.arms.iter().map(|arm| arm.graph.clone()).collect()
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        if let Some(arm) = self.arms.get(graph) {
            arm.tree.statuses(out);
        }
    }

    fn save(&self) -> Vec<u8> {
        self.to_checkpoint()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.take(bytes).inspect_err(|_| self.reset())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        self.resumed = true;
        // Zones and reservations are corrected for each arm before the next tick reads them.
        for (arm, it) in self.arms.iter().enumerate() {
            if let Some(shared) = self.boards.get_mut(it.board) {
                let mut world = World::new(&self.setup, observation, job, out, arm);
                shared::reconcile(&mut world, &mut shared.board);
            }
        }
    }
}
