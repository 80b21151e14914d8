//! The policy of the pyramid: one tree for each arm, ticked one after the other.

mod checkpoint;
mod report;

use robocell_task::TraceEvent;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crate::pyramid::numbers::PyramidTask;
use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::Tree;
use behavior::{Graph, NodeStatus, Status, Value};
use cell_model::Cell;
use ipc_types::Text;

use super::center::Lock;
use super::host::{self, PyramidHost, World};
use super::library::library;
use super::phases::{self, Phase};
use super::setup::{PyramidError, PyramidSetup};
use checkpoint::Memory;
use robocell_task::checkpoint::MAX_BYTES;
use robocell_task::job::{Counters, Job};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::AnyPolicy;
use robocell_task::tree_trace::{KeyWatch, TreeTrace};

/// One arm's tree.
struct Robot {
    tree: Tree<PyramidHost>,
    graph: Graph,
    /// Which of the boards it shares.
    board: usize,
    /// Phase by node.
    phases: Vec<Phase>,
    trace: TreeTrace,
    /// It failed at the tick before, which was said.
    failing: bool,
}

/// See the module.
pub struct Json {
    setup: Arc<PyramidSetup>,
    robots: Vec<Robot>,
    /// Names are those of the cell file.
    boards: Vec<(String, Board)>,
    memory: Memory,
    /// For the trace, one for each board.
    shared_keys: Vec<KeyWatch>,
    /// Nodes and keys of the checkpoint taken last that are no more in the file.
    lost: usize,
    /// The checkpoint of a policy that never ran.
    initial: Vec<u8>,
}

impl Json {
    /// The trees of `cell`, read from the files it names.
    ///
    /// # Errors
    /// [`PyramidError`] with everything that is wrong in a file.
    pub fn new(task: &PyramidTask, cell: &Cell) -> Result<Self, PyramidError> {
        let setup = Arc::new(PyramidSetup::new(task, cell)?);
        let mut policy = Self {
            memory: Memory::new(setup.arms.len()),
            setup,
            robots: Vec::new(),
            boards: Vec::new(),
            shared_keys: Vec::new(),
            lost: 0,
            initial: Vec::new(),
        };
        for arm in 0..policy.setup.arms.len() {
            policy.add_robot(arm, cell)?;
        }
        policy.initial = policy.save();
        // A checkpoint that does not fit is written empty.
        let allowed = usize::try_from(MAX_BYTES / 2).unwrap_or(usize::MAX);
        let found = policy.initial.len();
        if found == 0 || found > allowed {
            return Err(PyramidError::TooLarge { found, allowed });
        }
        Ok(policy)
    }

    fn add_robot(&mut self, arm: usize, cell: &Cell) -> Result<(), PyramidError> {
        let setup = Arc::clone(&self.setup);
        let Some(spec) = setup.arms.get(arm) else {
            return Ok(());
        };
        let board = self.board_named(&spec.board);
        let Some((_, shared)) = self.boards.get_mut(board) else {
            return Ok(());
        };
        let text = cell.read(&spec.behaviour)?;
        let include = |name: &str| cell.read(name).ok().map(std::borrow::Cow::into_owned);
        let source = Source {
            file: &spec.behaviour,
            text: &text,
            include: &include,
        };
        let required = i64::from(setup.numbers.required_count);
        let constants = BTreeMap::from([
            ("robot".to_owned(), Value::Text(spec.name)),
            ("required_count".to_owned(), Value::Integer(required)),
        ]);
        let tree = grow(&source, &setup, &constants, shared)?;
        let mut graph = tree.graph();
        spec.name.as_str().clone_into(&mut graph.name);
        self.robots.push(Robot {
            trace: TreeTrace::new(&graph),
            failing: false,
            phases: phases::names(spec.name.as_str(), &graph),
            tree,
            graph,
            board,
        });
        Ok(())
    }

    fn board_named(&mut self, name: &str) -> usize {
        let known = self.boards.iter().position(|(known, _)| known == name);
        known.unwrap_or_else(|| {
            self.boards.push((name.to_owned(), Board::new()));
            self.shared_keys.push(KeyWatch::default());
            self.boards.len() - 1
        })
    }

    /// A board by its name in the cell file.
    pub fn board(&self, name: &str) -> Option<&Board> {
        let mut boards = self.boards.iter();
        boards.find_map(|(known, board)| (known == name).then_some(board))
    }

    /// Renews the lease of every centre's owner that works, and frees centres
    /// whose owner does not.
    fn watch_centers(&mut self, observation: &Observation<'_>, now: Duration, out: &mut Output) {
        for (_, board) in &mut self.boards {
            let Some(lock) = Lock::find(board) else {
                continue;
            };
            let owner = self.setup.arm_named(lock.owner(board).as_str());
            let works = owner.is_some_and(|arm| {
                !self.memory.is_finished(arm) && host::is_alive(observation, arm)
            });
            if let Some(lost) = lock.watch(board, now.as_secs_f64(), works) {
                out.event(
                    TraceEvent::Recover,
                    format_args!("[center] {lost} does not answer, the centre is free"),
                );
            }
        }
    }

    /// One tick of the tree of `arm`.
    fn tick_robot(
        &mut self,
        arm: usize,
        now: Duration,
        observation: &Observation<'_>,
        counters: &mut Counters,
        out: &mut Output,
    ) {
        let Some(robot) = self.robots.get_mut(arm) else {
            return;
        };
        let Some((_, board)) = self.boards.get_mut(robot.board) else {
            return;
        };
        let mut world = World {
            observation,
            setup: &self.setup,
            arm,
            last_key: &mut self.memory.last_key,
            counters,
            out,
        };
        let status = robot.tree.tick(now, board, &mut world);
        robot.trace.tick(&robot.tree, arm, out);
        self.memory.shown.note(arm, robot.tree.tip());
        if status == Status::Running {
            robot.failing = false;
            return;
        }
        let name = self.setup.arms.get(arm).map(|a| a.name).unwrap_or_default();
        if let Some(lock) = Lock::find(board)
            && lock.owner(board) == name
        {
            lock.free(board);
        }
        if status == Status::Success {
            self.memory.finish(arm);
            out.event(
                TraceEvent::Done,
                format_args!("[done] {name}: the stack is complete"),
            );
        } else if !std::mem::replace(&mut robot.failing, true) {
            out.event(
                TraceEvent::Fault,
                format_args!("[error] {name}: the tree failed, begins anew"),
            );
        }
    }

    /// Says which shared keys have a new value.
    fn trace_keys(&mut self, out: &mut Output) {
        for (watch, (name, board)) in self.shared_keys.iter_mut().zip(&self.boards) {
            watch.changes(board, name, 0, out);
        }
    }
}

impl AnyPolicy for Json {
    fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It was written by this very policy.
        let _taken = self.restore(&initial).is_ok();
        self.initial = initial;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let now = Duration::from_millis(observation.time().ticks());
        self.watch_centers(observation, now, out);
        let lost = std::mem::take(&mut self.lost);
        if lost > 0 {
            out.lifecycle(
                TraceEvent::None,
                format_args!(
                    "[task] {lost} nodes or keys of the checkpoint are not in the files any more"
                ),
            );
        }
        for arm in 0..self.robots.len() {
            if !self.memory.is_finished(arm) {
                self.tick_robot(arm, now, observation, &mut job.counters, out);
            }
        }
        self.trace_keys(out);
        self.report(observation, job, out);
    }

    fn phase(&self) -> Text<32> {
        let current = self.memory.shown.current();
        current
            .and_then(|(arm, node)| self.robots.get(arm)?.phases.get(node).copied())
            .unwrap_or(Text::EMPTY)
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        self.robots.iter().map(|r| r.graph.clone()).collect()
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        if let Some(robot) = self.robots.get(graph) {
            robot.tree.statuses(out);
        }
    }

    fn save(&self) -> Vec<u8> {
        self.to_checkpoint()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        self.take_checkpoint(bytes).inspect_err(|_| self.reset())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        for arm in 0..self.robots.len() {
            self.reconcile_arm(arm, observation, job, out);
        }
    }
}

/// The tree of a file for one arm; `shared` gets the keys it shares.
pub(super) fn grow(
    source: &Source<'_>,
    setup: &Arc<PyramidSetup>,
    constants: &BTreeMap<String, Value>,
    shared: &mut Board,
) -> Result<Tree<PyramidHost>, PyramidError> {
    let read = descriptor::read(source, &library(setup), constants, shared)
        .map_err(|errors| PyramidError::Descriptor(errors.to_string()))?;
    let tree = Tree::new(&read.name, read.root, read.local)
        .map_err(|error| PyramidError::Descriptor(format!("{}: {error}", source.file)))?;
    *shared = read.shared;
    Ok(tree)
}
