//! The stacking job as a behaviour tree written in code: priorities from left
//! to right, three blackboard keys, recovery branches before the normal flow.

pub mod keys;
pub mod leaves;
pub mod phase_leaf;
pub mod shape;
pub mod world;

use robocell_task::TraceEvent;
use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::tree::Tree;
use behavior::{Graph, NodeStatus, Str, Value};
use ipc_types::{GripperGoal, Text};
use serde::{Deserialize, Serialize};

use self::world::{StackHost, StackWorld};
use crate::stack::resume::{InHand, in_hand};
use crate::stack::scene::ARM;
use crate::stack::{Phase, SetupError, StackSetup, View, command, recovery};
use robocell_task::checkpoint;
use robocell_task::job::{Job, Placement};
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::AnyPolicy;
use robocell_task::tree_trace::TreeTrace;

/// See the module.
pub struct StackBt {
    setup: Arc<StackSetup>,
    tree: Tree<StackHost>,
    /// Nothing is shared: there is one tree.
    shared: Board,
    phase: Option<Phase>,
    unsettled: bool,
    trace: TreeTrace,
}

#[derive(Serialize, Deserialize)]
struct Saved {
    phase: Option<Phase>,
    #[serde(with = "serde_bytes")]
    tree: Vec<u8>,
}

impl StackBt {
    /// A tree that has not begun.
    ///
    /// # Errors
    /// [`SetupError::Tree`], which would be a mistake in here.
    pub fn new(setup: Arc<StackSetup>) -> Result<Self, SetupError> {
        let tree = grow(&setup)?;
        Ok(Self {
            trace: TreeTrace::new(&tree.graph()),
            tree,
            setup,
            shared: Board::new(),
            phase: None,
            unsettled: false,
        })
    }

    /// Starts over; the tree that is there was proved to grow.
    fn replant(&mut self) {
        if let Ok(tree) = grow(&self.setup) {
            self.tree = tree;
        }
        self.phase = None;
    }

    fn set(&mut self, key: &str, value: Value) {
        let board = self.tree.local_mut();
        if let Some(index) = board.index(key) {
            board.set(index, value);
        }
    }

    fn has_gripped(&self) -> bool {
        let board = self.tree.local();
        let key = board.index(keys::PICKUP_POSITION);
        key.and_then(|index| board.value(index)).is_some()
    }

    /// Goes on with a cube that is in the hand already: the leaves that pick up
    /// find it held, and succeed at once.
    fn adopt(&mut self, found: InHand, job: &mut Job, out: &mut Output) {
        let name = self.setup.name(found.cube);
        out.event(
            TraceEvent::Recover,
            format_args!("[resume] {name} is in the hand"),
        );
        let name = Value::Text(Str::new(name).unwrap_or_default());
        self.replant();
        self.set(keys::PICK_TARGET, name);
        self.set(keys::HOLDING, name);
        let Placement { position, yaw } = found.pickup;
        let [x, y, z] = position;
        let gripped = behavior::value::Numbers::new(&[x, y, z, yaw]).unwrap_or_default();
        self.set(keys::PICKUP_POSITION, Value::Numbers(gripped));
        job.counters.recoveries += 1;
        job.done = false;
        job.held = self.setup.cube(found.cube).map(|c| c.object);
        job.destination = Some(found.destination);
        job.aborted = found.aborted;
    }
}

fn grow(setup: &StackSetup) -> Result<Tree<StackHost>, SetupError> {
    let broken = |problem: String| SetupError::Tree { problem };
    let (root, board) =
        shape::tree(setup.spec.holds_until_retracted).map_err(|e| broken(e.to_string()))?;
    Tree::new("bt", root, board).map_err(|e| broken(e.to_string()))
}

impl AnyPolicy for StackBt {
    fn reset(&mut self) {
        self.replant();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
            return;
        };
        let now = observation.time();
        let mut world = StackWorld {
            setup: &setup,
            scene: &scene,
            observation,
            now,
            unsettled: std::mem::take(&mut self.unsettled),
            job,
            out,
            intent: None,
            gripper: GripperGoal::Keep,
        };
        let elapsed = Duration::from_millis(now.ticks());
        self.tree.tick(elapsed, &mut self.shared, &mut world);
        let (intent, gripper) = (world.intent, world.gripper);
        self.phase = intent.map(|(phase, _)| phase);
        let idle = || command::hold(gripper);
        out.arm(ARM, intent.map_or_else(idle, |(_, intent)| intent));
        self.trace.tick(&self.tree, 0, out);
        command::report(&setup, &scene, self.phase, job, out);
    }

    fn phase(&self) -> Text<32> {
        self.phase
            .map_or(Text::EMPTY, |phase| Text::new(phase.name()))
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        vec![self.tree.graph()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.tree.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        let mut tree = Vec::new();
        self.tree.save(&mut tree);
        checkpoint::to_bytes(&Saved {
            phase: self.phase,
            tree,
        })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let saved: Saved = checkpoint::from_bytes(bytes)?;
        self.replant();
        match self.tree.restore(&saved.tree) {
            Ok(_carried) => {
                self.phase = saved.phase;
                Ok(())
            }
            Err(error) => Err(serde::de::Error::custom(error)),
        }
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
            return;
        };
        if self.has_gripped() {
            self.unsettled = true;
        } else if let Some(found) = in_hand(&setup, &scene, job) {
            self.adopt(found, job, out);
        } else {
            recovery::forget_held(job);
            self.replant();
        }
    }
}
