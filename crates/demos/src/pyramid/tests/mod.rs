//! One node of the library in a tree of its own, in a cell that stands still
//! unless the test moves it.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on has failed"
)]

mod nodes_check;
mod nodes_move;
mod nodes_take;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use crate::pyramid::numbers::PyramidTask;
use behavior::board::Board;
use behavior::descriptor::Source;
use behavior::tree::Tree;
use behavior::value::Set;
use behavior::{Status, Str, Value};
use cell_model::{Cell, Data};
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmGoal, ArmStatus, Decision, GripperGoal, Header, Pose, Wire, WorldState};

use super::host::{PyramidHost, World};
use super::setup::PyramidSetup;
use super::targets::{Numbers, to_numbers};
use robocell_task::job::Counters;
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::time::PolicyTime;

const LEFT: usize = 0;
const RIGHT: usize = 1;
const FILE: &str = "franka-pyramid.tree.json";

struct Bench {
    setup: Arc<PyramidSetup>,
    state: Box<WorldState>,
    status: [ArmStatus; 2],
    tree: Tree<PyramidHost>,
    shared: Board,
    arm: usize,
    now: Duration,
    out: Output,
    decision: Box<Decision>,
    counters: Counters,
    last_key: u64,
    lines: Vec<String>,
    /// The controllers are not heard.
    mute: bool,
}

impl Bench {
    /// A tree of one node, `{"type": ..., "ports": ...}`, for `arm`.
    fn new(arm: usize, node: serde_json::Value) -> Self {
        let cell = Cell::load(&Data::checkout(), "franka-pyramid", 1, None).unwrap();
        let task: PyramidTask = cell.task.read().unwrap();
        let setup = Arc::new(PyramidSetup::new(&task, &cell).unwrap());
        let mut shared = Board::new();
        let tree = grow(&cell, &setup, arm, node, &mut shared);
        let mut state = Box::new(WorldState::zeroed());
        state.header = Header::caused_by::<WorldState>(0);
        state.arm_count = 2;
        for (index, arm) in state.arms[..2].iter_mut().enumerate() {
            arm.tcp = Pose {
                position: [0.4, index as f64 - 0.5, 0.4],
                orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
            };
            arm.gripper.width = 0.08;
        }
        state.object_count = 6;
        for (object, spec) in state.objects.iter_mut().zip(&cell.objects) {
            object.flags = OBJECT_ENABLED;
            object.pose.position = spec.pose.translation.vector.into();
            object.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
        }
        Self {
            setup,
            state,
            status: [ArmStatus::zeroed(); 2],
            tree,
            shared,
            arm,
            now: Duration::ZERO,
            out: Output::default(),
            decision: Box::new(Decision::zeroed()),
            counters: Counters::default(),
            last_key: 0,
            lines: Vec::new(),
            mute: false,
        }
    }

    /// Time passes, then the tree is ticked.
    fn tick_after(&mut self, seconds: f64) -> Status {
        self.now += Duration::from_secs_f64(seconds);
        let tick = u64::try_from(self.now.as_millis()).unwrap();
        self.state.header = Header::caused_by::<WorldState>(tick);
        for (status, goal) in self.status.iter_mut().zip(&self.decision.goals) {
            if self.mute {
                continue;
            }
            status.header = Header::caused_by::<ArmStatus>(tick);
            status.goal_id = goal.goal_id;
            status.goal_active = u32::from(goal.kind != GoalKind::Hold.code());
        }
        let heard = [Some(&self.status[0]), Some(&self.status[1])];
        let observation = Observation::new(&self.state, &heard, PolicyTime::from_ticks(tick));
        self.out.begin();
        let mut world = World {
            observation: &observation,
            setup: &self.setup,
            arm: self.arm,
            last_key: &mut self.last_key,
            counters: &mut self.counters,
            out: &mut self.out,
        };
        let status = self.tree.tick(self.now, &mut self.shared, &mut world);
        let mut trace = Vec::new();
        self.out.finish(2, &mut self.decision, &mut trace);
        let people = trace.iter().filter(|l| l.kind.is_for_people());
        self.lines
            .extend(people.map(|l| l.text.as_str().to_owned()));
        status
    }

    /// Ticks 10 ms after the tick before.
    fn tick(&mut self) -> Status {
        self.tick_after(0.01)
    }

    fn goal(&self) -> ArmGoal {
        self.decision.goals[self.arm]
    }

    fn holds_still(&self) -> bool {
        self.goal().kind == GoalKind::Hold.code()
    }

    fn gripper(&self) -> GripperGoal {
        GripperGoal::from_code(self.goal().gripper).unwrap()
    }

    fn set(&mut self, key: &str, value: Value) {
        let index = self.shared.index(key).unwrap();
        assert!(self.shared.set(index, value), "{key}");
    }

    fn set_text(&mut self, key: &str, text: &str) {
        self.set(key, Value::Text(Str::new(text).unwrap()));
    }

    fn set_local(&mut self, key: &str, value: Value) {
        let board = self.tree.local_mut();
        let index = board.index(key).unwrap();
        assert!(board.set(index, value), "{key}");
    }

    fn get(&self, key: &str) -> Option<Value> {
        self.shared.value(self.shared.index(key).unwrap())
    }

    fn text(&self, key: &str) -> String {
        match self.get(key) {
            Some(Value::Text(text)) => text.to_string(),
            other => panic!("{key} is {other:?}"),
        }
    }

    fn local(&self, key: &str) -> Option<Value> {
        let board = self.tree.local();
        board.value(board.index(key).unwrap())
    }

    fn current(&self) -> String {
        match self.local("current_cube") {
            Some(Value::Text(text)) => text.to_string(),
            other => panic!("{other:?}"),
        }
    }

    fn target(&self, key: &str) -> Option<Numbers> {
        match self.local(key)? {
            Value::Numbers(numbers) => numbers.as_slice().try_into().ok(),
            other => panic!("{other:?}"),
        }
    }

    fn recovery(&self) -> bool {
        let robot = self.setup.arms[self.arm].name;
        self.get(&format!("recovery_requested:{robot}")) == Some(Value::Bool(true))
    }

    /// Everything on the shared board.
    fn all(&self) -> Vec<Option<Value>> {
        let count = self.shared.keys().count();
        (0..count).map(|key| self.shared.value(key)).collect()
    }

    fn cube(&mut self, cube: usize) -> &mut [f64; 3] {
        &mut self.state.objects[cube].pose.position
    }

    /// The tree works at `cube`, whose targets were made where it is.
    fn works_at(&mut self, cube: usize, targets: &[&str], pose: Pose) {
        let name = Value::Text(self.setup.cube_name(cube));
        let here = self.state.objects[cube].pose.position;
        let numbers =
            |values: &[f64]| Value::Numbers(behavior::value::Numbers::new(values).unwrap());
        self.set_local("current_cube", name);
        self.set_local("pickup_reference", numbers(&here));
        for target in targets {
            self.set_local(target, numbers(&to_numbers(&pose)));
        }
    }

    /// The cube is between the fingers.
    fn hold(&mut self, cube: usize) {
        let arm = &mut self.state.arms[self.arm];
        arm.gripper.width = 0.05;
        arm.gripper.held_object = u32::try_from(cube).unwrap() + 1;
        self.state.objects[cube].pose.position = arm.tcp.position;
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }
}

fn grow(
    cell: &Cell,
    setup: &Arc<PyramidSetup>,
    arm: usize,
    mut node: serde_json::Value,
    shared: &mut Board,
) -> Tree<PyramidHost> {
    let text = cell.read(FILE).unwrap();
    let mut file: serde_json::Value = serde_json::from_str(&text).unwrap();
    node["id"] = "node".into();
    file["root"] = node;
    let text = file.to_string();
    let source = Source {
        file: FILE,
        text: &text,
        include: &|_| None,
    };
    let constants = BTreeMap::from([("robot".to_owned(), Value::Text(setup.arms[arm].name))]);
    super::policy::grow(&source, setup, &constants, shared).unwrap_or_else(|e| panic!("{e}"))
}

fn set_of(cubes: &[u32]) -> Value {
    let set = cubes
        .iter()
        .fold(Set::default(), |set, cube| set.with(*cube));
    Value::Set(set)
}

fn pose(x: f64, y: f64, z: f64) -> Pose {
    Pose {
        position: [x, y, z],
        orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
    }
}
