//! Trees in files, one for each arm. Trees that name the same blackboard share it.

mod build;
mod checkpoint;
mod tick;
mod zone_order;

use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::board::Board;
use behavior::tree::{Library, Tree};
use behavior::{Graph, NodeStatus, Status, Value};
use cell_model::Cell;
use cell_model::cells::replace::Replace;
use ipc_types::{MAX_ARMS, Text};
use robocell_task::replaced::replace_leaves;
use robocell_task::tree_trace::{KeyWatch, TreeTrace};
use robocell_task::{AnyPolicy, Job, Observation, Output, SetupError, TraceEvent};

use super::parts;
use super::phases::{Phase, Shown};
use crate::condition::PLACE_TOLERANCE_M;
use crate::nodes;
use crate::setup::Setup;
use crate::shared;
use crate::shared::lease::Zones;
use crate::skill::Station;
use crate::world::{ArmMemory, World};
use tick::{fail_deadlock, was_undone};

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
    /// No tree commands an arm that has a client.
    is_absent: bool,
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
    /// A shared blackboard, by its name in the cell file.
    pub fn board(&self, name: &str) -> Option<&Board> {
        let shared = self.boards.iter().find(|known| known.name == name);
        shared.map(|shared| &shared.board)
    }

    fn is_done(&self) -> bool {
        let mut arms = self.arms.iter().filter(|arm| !arm.is_absent);
        arms.all(|arm| arm.status == Status::Success)
    }

    /// Whether there are several arms. With one arm a goal is a phase, and the job has the held
    /// object.
    fn is_of_several(&self) -> bool {
        self.arms.len() > 1
    }
}

impl AnyPolicy for TreePolicy {
    fn warnings(&self, cell: &Cell) -> Vec<String> {
        let mut warnings = parts::warnings(self.arms.iter().map(|arm| &arm.tree));
        warnings.extend(self.setup.far_picks(cell));
        for board in 0..self.boards.len() {
            let names = self.setup.arms.iter().map(|arm| arm.name.as_str());
            let arms = names.zip(&self.arms).filter(|(_, arm)| arm.board == board);
            let arms: Vec<_> = arms.map(|(name, arm)| (name, &arm.graph)).collect();
            warnings.extend(zone_order::warnings(&arms));
        }
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
        let mut waits = [None; MAX_ARMS];
        for arm in 0..self.arms.len() {
            let Some(it) = self.arms.get(arm).filter(|it| !it.is_absent) else {
                continue;
            };
            let (mut memory, status) = (it.memory, it.status);
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
            if let Some(wait) = waits.get_mut(arm) {
                *wait = world.zone_wait;
            }
            if let Some(it) = self.arms.get_mut(arm) {
                it.memory = memory;
            }
        }
        for shared in &mut self.boards {
            shared.watch.changes(&shared.board, &shared.name, 0, out);
        }
        let mut world = World::new(&setup, observation, job, out, 0);
        world.report_within(self.is_done(), self.tolerance_m);
        fail_deadlock(&waits, &mut world);
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
