//! The policy of the pyramid: one tree for each arm, ticked one after the other.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::Tree;
use behavior::{Graph, NodeStatus, Status, Value};
use cell_model::Cell;
use cell_model::task_spec::PyramidTask;
use ipc_types::Text;
use ipc_types::decision::Outcome;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

use super::center::Lock;
use super::cubes::is_at;
use super::host::{self, PyramidHost, World};
use super::keys;
use super::library::library;
use super::phases::{self, Phase, Shown};
use super::setup::{PyramidError, PyramidSetup};
use crate::job::{Counters, Job};
use crate::observation::Observation;
use crate::output::Output;
use crate::policy::Policy;
use crate::record::{self, MAX_RECORD_BYTES};
use crate::tree_trace::{KeyWatch, TreeTrace};

/// Version of the layout of [`Record`].
const VERSION: u32 = 1;

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

/// What the policy remembers beside trees and boards.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Memory {
    /// Key of the newest goal.
    last_key: u64,
    /// By arm: its tree succeeded and is not ticked again.
    finished: Vec<bool>,
    shown: Shown,
}

#[derive(Serialize, Deserialize)]
struct Record {
    version: u32,
    /// Tells one list of nodes from another.
    shape: u64,
    trees: Vec<ByteBuf>,
    boards: Vec<ByteBuf>,
    memory: Memory,
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
    /// Nodes and keys of the record taken last that are no more in the file.
    lost: usize,
    /// The record of a policy that never ran.
    initial: Vec<u8>,
}

impl Json {
    /// Name on the command line.
    pub const NAME: &'static str = "json";

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
        // A record that does not fit is written empty.
        let allowed = usize::try_from(MAX_RECORD_BYTES / 2).unwrap_or(usize::MAX);
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
                out.log(format_args!(
                    "[center] {lost} does not answer, the centre is free"
                ));
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
            out.log(format_args!("[done] {name}: the stack is complete"));
        } else if !std::mem::replace(&mut robot.failing, true) {
            out.log(format_args!("[error] {name}: the tree failed, begins anew"));
        }
    }

    /// Says which shared keys have a new value.
    fn trace_keys(&mut self, out: &mut Output) {
        for (watch, (name, board)) in self.shared_keys.iter_mut().zip(&self.boards) {
            watch.changes(board, name, 0, out);
        }
    }

    /// Says how the job stands.
    fn report(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        if self.memory.shown.advance() {
            job.counters.phase_entry += 1;
        }
        out.phase = self.phase();
        job.done = self.memory.finished.iter().all(|finished| *finished);
        out.outcome = if job.done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        job.placed.clear();
        for (arm, robot) in self.robots.iter().enumerate() {
            let (Some(spec), Some((_, board))) =
                (self.setup.arms.get(arm), self.boards.get(robot.board))
            else {
                continue;
            };
            let key = board
                .keys()
                .position(|k| is_placed_key(&k.name, spec.name.as_str()));
            let Some(Value::Set(set)) = key.and_then(|key| board.value(key)) else {
                continue;
            };
            let mut unused = (0, Counters::default());
            let world = World {
                observation,
                setup: &self.setup,
                arm,
                last_key: &mut unused.0,
                counters: &mut unused.1,
                out,
            };
            for cube in set.items() {
                let stands = (0..set.len())
                    .any(|layer| is_at(&world, cube as usize, self.setup.goal(spec, layer)));
                let object = self.setup.cubes.get(cube as usize).map(|c| c.object);
                if let Some(object) = object.filter(|_| stands) {
                    job.placed.push(u32::try_from(object).unwrap_or(u32::MAX));
                }
            }
        }
        job.placed.sort_unstable();
    }

    /// A number for the ids of all nodes, FNV-1a.
    fn shape(&self) -> u64 {
        let nodes = self.robots.iter().flat_map(|r| &r.graph.nodes);
        let bytes = nodes.flat_map(|n| n.id.bytes().chain([0]));
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }

    fn take(&mut self, record: &Record) -> Result<(), bincode::Error> {
        let fits = record.version == VERSION
            && record.trees.len() == self.robots.len()
            && record.boards.len() == self.boards.len()
            && record.memory.finished.len() == self.robots.len();
        if !fits {
            return Err(foreign("another version, or another cell"));
        }
        self.lost = 0;
        for ((_, board), bytes) in self.boards.iter_mut().zip(&record.boards) {
            self.lost += board.restore(bytes).map_err(foreign)?.lost;
        }
        for (robot, bytes) in self.robots.iter_mut().zip(&record.trees) {
            self.lost += robot.tree.restore(bytes).map_err(foreign)?.lost;
        }
        self.memory = record.memory.clone();
        if record.shape != self.shape() {
            // The nodes have other numbers now.
            let tips = self.robots.iter().map(|r| r.tree.tip());
            self.memory.shown.begin_at(tips.collect());
        }
        Ok(())
    }
}

impl Memory {
    fn new(arms: usize) -> Self {
        Self {
            last_key: 0,
            finished: vec![false; arms],
            shown: Shown::new(arms),
        }
    }

    fn is_finished(&self, arm: usize) -> bool {
        self.finished.get(arm).copied().unwrap_or(false)
    }

    fn finish(&mut self, arm: usize) {
        if let Some(finished) = self.finished.get_mut(arm) {
            *finished = true;
        }
    }
}

impl Policy for Json {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn reset(&mut self) {
        let initial = std::mem::take(&mut self.initial);
        // It was written by this very policy.
        let _taken = self.restore(&initial).is_ok();
        self.initial = initial;
    }

    fn tick(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let now = Duration::from_millis(observation.time().ticks());
        self.watch_centers(observation, now, out);
        let lost = std::mem::take(&mut self.lost);
        if lost > 0 {
            out.lifecycle(format_args!(
                "[task] {lost} nodes or keys of the record are not in the files any more"
            ));
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

    fn describe(&self) -> Vec<Graph> {
        self.robots.iter().map(|r| r.graph.clone()).collect()
    }

    fn statuses(&self, graph: usize, out: &mut Vec<NodeStatus>) {
        if let Some(robot) = self.robots.get(graph) {
            robot.tree.statuses(out);
        }
    }

    fn save(&self) -> Vec<u8> {
        let mut record = Record {
            version: VERSION,
            shape: self.shape(),
            trees: Vec::new(),
            boards: Vec::new(),
            memory: self.memory.clone(),
        };
        for robot in &self.robots {
            let mut bytes = Vec::new();
            robot.tree.save(&mut bytes);
            record.trees.push(ByteBuf::from(bytes));
        }
        for (_, board) in &self.boards {
            let mut bytes = Vec::new();
            board.save(&mut bytes);
            record.boards.push(ByteBuf::from(bytes));
        }
        record::to_bytes(&record)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = record::from_bytes(bytes)?;
        self.take(&record).inspect_err(|_| self.reset())
    }

    /// What was carried and is not in the hand any more was lost in the
    /// meantime. Everything else is seen by the nodes themselves: a cube in the
    /// hand is gone on with, a cube that moved is picked up anew.
    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        for (arm, robot) in self.robots.iter().enumerate() {
            let (Some(spec), Some((_, board))) =
                (self.setup.arms.get(arm), self.boards.get_mut(robot.board))
            else {
                continue;
            };
            let mut unused = 0;
            let world = World {
                observation,
                setup: &self.setup,
                arm,
                last_key: &mut unused,
                counters: &mut job.counters,
                out,
            };
            let held = world.cube_in_hand();
            let carried = (0..self.setup.cubes.len()).find(|cube| {
                let key = keys::cube_state(self.setup.cube_name(*cube).as_str());
                let state = board.index(&key).and_then(|key| board.value(key));
                matches!(state, Some(Value::Text(s)) if s.as_str() == format!("carried:{}", spec.name))
            });
            if let Some(held) = held {
                let name = self.setup.cube_name(held);
                world.out.log(format_args!(
                    "[resume] {}: {name} is in the hand",
                    spec.name
                ));
            }
            let flag = board.index(&keys::recovery_requested(spec.name.as_str()));
            if let (Some(_), Some(flag)) = (carried.filter(|_| carried != held), flag) {
                world.counters.recoveries += 1;
                board.set(flag, Value::Bool(true));
            }
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

fn is_placed_key(key: &str, arm: &str) -> bool {
    key.strip_prefix(keys::PLACED) == Some(arm)
}

#[allow(
    clippy::unnecessary_box_returns,
    reason = "the error of bincode is a box"
)]
fn foreign(why: impl std::fmt::Display) -> bincode::Error {
    let text = format!("not a record of these trees: {why}");
    serde::de::Error::custom(text)
}
