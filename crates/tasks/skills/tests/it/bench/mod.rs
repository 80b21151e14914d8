//! One node of a library in a separate tree, for one of two arms, in a cell that is at rest
//! unless the test moves it. Other packages include this file by its path.
#![allow(dead_code, reason = "not every package needs all of it")]

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Library, Tree};
use behavior::{Status, Str, Value};
use cell_model::Cell;
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmGoal, ArmStatus, Decision, GripperGoal, Header, Pose, Wire, WorldState};
use robocell_skills::setup::Setup;
use robocell_skills::{ArmMemory, Station, World};
use robocell_task::{Job, Observation, Output, PolicyTime};

pub(crate) const LEFT: usize = 0;
pub(crate) const RIGHT: usize = 1;

pub(crate) struct Bench {
    pub(crate) setup: Arc<Setup>,
    pub(crate) state: Box<WorldState>,
    status: [ArmStatus; 2],
    tree: Tree<Station>,
    shared: Board,
    arm: usize,
    began: Vec<[f64; 3]>,
    now: Duration,
    out: Output,
    decision: Box<Decision>,
    pub(crate) job: Job,
    memory: ArmMemory,
    pub(crate) lines: Vec<String>,
    /// The controllers do not answer.
    pub(crate) mute: bool,
}

impl Bench {
    /// The tree `file` for `arm` of `cell`.
    #[track_caller]
    pub(crate) fn of(
        (cell, setup): (&Cell, Arc<Setup>),
        library: &Library<Station>,
        arm: usize,
        file: &serde_json::Value,
    ) -> Self {
        let text = file.to_string();
        let source = Source {
            file: "bench.tree.json",
            text: &text,
            include: &|_| Err(String::new()),
        };
        let robot = Value::Text(Str::new(&cell.arms[arm].name).unwrap());
        let constants = BTreeMap::from([("robot".to_owned(), robot)]);
        let mut shared = Board::new();
        let tree = descriptor::load(&source, library, &constants, &mut shared)
            .unwrap_or_else(|errors| panic!("{errors}"));
        Self {
            setup,
            state: at_rest(cell),
            status: [ArmStatus::zeroed(); 2],
            tree,
            shared,
            arm,
            began: cell
                .objects
                .iter()
                .map(|of| of.pose.translation.vector.into())
                .collect(),
            now: Duration::ZERO,
            out: Output::default(),
            decision: Box::new(Decision::zeroed()),
            job: Job::new(cell.objects.len()),
            memory: ArmMemory::default(),
            lines: Vec::new(),
            mute: false,
        }
    }

    /// Time passes, then the tree is ticked.
    pub(crate) fn tick_after(&mut self, seconds: f64) -> Status {
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
        let (job, out) = (&mut self.job, &mut self.out);
        let mut world = World::new(&self.setup, &observation, job, out, self.arm);
        world.memory = Some(&mut self.memory);
        let status = self.tree.tick(self.now, &mut self.shared, &mut world);
        world.finish();
        let mut trace = Vec::new();
        self.out.finish(2, &mut self.decision, &mut trace);
        let people = trace.iter().filter(|l| l.kind.is_for_people());
        self.lines
            .extend(people.map(|l| l.text.as_str().to_owned()));
        status
    }

    /// Ticks 10 ms after the tick before.
    pub(crate) fn tick(&mut self) -> Status {
        self.tick_after(0.01)
    }

    pub(crate) fn goal(&self) -> ArmGoal {
        self.decision.goals[self.arm]
    }

    /// What the arm waits for, as the decision reports it.
    pub(crate) fn wait(&self) -> &str {
        self.decision.wait.as_str()
    }

    pub(crate) fn holds_still(&self) -> bool {
        self.goal().kind == GoalKind::Hold.code()
    }

    pub(crate) fn gripper(&self) -> GripperGoal {
        GripperGoal::from_code(self.goal().gripper).unwrap()
    }

    pub(crate) fn set(&mut self, key: &str, value: Value) {
        let index = self.shared.index(key).unwrap();
        assert!(self.shared.set(index, value), "{key}");
    }

    pub(crate) fn set_text(&mut self, key: &str, text: &str) {
        self.set(key, Value::Text(Str::new(text).unwrap()));
    }

    pub(crate) fn set_local(&mut self, key: &str, value: Value) {
        let board = self.tree.local_mut();
        let index = board.index(key).unwrap();
        assert!(board.set(index, value), "{key}");
    }

    pub(crate) fn get(&self, key: &str) -> Option<Value> {
        self.shared.value(self.shared.index(key).unwrap())
    }

    pub(crate) fn text(&self, key: &str) -> String {
        text(self.get(key))
    }

    pub(crate) fn local(&self, key: &str) -> Option<Value> {
        let board = self.tree.local();
        board.value(board.index(key).unwrap())
    }

    pub(crate) fn local_text(&self, key: &str) -> String {
        text(self.local(key))
    }

    /// Whether a recovery is requested from the arm's tree.
    pub(crate) fn recovery(&self) -> bool {
        let robot = &self.setup.arms[self.arm].name;
        self.get(&format!("recovery_requested:{robot}")) == Some(Value::Bool(true))
    }

    /// Everything on the shared board.
    pub(crate) fn all(&self) -> Vec<Option<Value>> {
        let count = self.shared.keys().count();
        (0..count).map(|key| self.shared.value(key)).collect()
    }

    /// Where the cell file has an object.
    pub(crate) fn setup_position(&self, object: usize) -> [f64; 3] {
        self.began[object]
    }

    /// Where an object is.
    pub(crate) fn object(&mut self, object: usize) -> &mut [f64; 3] {
        &mut self.state.objects[object].pose.position
    }

    /// The tree works at `object`, by these two keys, and aimed at it where it is.
    pub(crate) fn works_at(&mut self, (current, reference): (&str, &str), object: usize) {
        let name = Str::new(&self.setup.objects[object].name).unwrap();
        let here = *self.object(object);
        self.set_local(current, Value::Text(name));
        self.set_local(reference, numbers(&here));
    }

    /// The object is between the fingers.
    pub(crate) fn hold(&mut self, object: usize) {
        let arm = &mut self.state.arms[self.arm];
        arm.gripper.width = 0.05;
        arm.gripper.held_object = u32::try_from(object).unwrap() + 1;
        self.state.objects[object].pose.position = arm.tcp.position;
    }

    pub(crate) fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }
}

/// The cell of the file, both arms beside each other with open grippers.
fn at_rest(cell: &Cell) -> Box<WorldState> {
    let mut state = Box::new(WorldState::zeroed());
    state.header = Header::caused_by::<WorldState>(0);
    state.arm_count = 2;
    for (arm, y) in state.arms[..2].iter_mut().zip([-0.5, 0.5]) {
        arm.tcp = pose(0.4, y, 0.4);
        arm.gripper.width = 0.08;
    }
    state.object_count = u32::try_from(cell.objects.len()).unwrap();
    for (object, spec) in state.objects.iter_mut().zip(&cell.objects) {
        object.flags = OBJECT_ENABLED;
        object.pose.position = spec.pose.translation.vector.into();
        object.pose.orientation_wxyz = [1.0, 0.0, 0.0, 0.0];
    }
    state
}

fn text(value: Option<Value>) -> String {
    match value {
        Some(Value::Text(text)) => text.to_string(),
        other => panic!("no text: {other:?}"),
    }
}

pub(crate) fn numbers(values: &[f64]) -> Value {
    Value::Numbers(behavior::value::Numbers::new(values).unwrap())
}

/// The tool straight down.
pub(crate) fn pose(x: f64, y: f64, z: f64) -> Pose {
    Pose {
        position: [x, y, z],
        orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
    }
}
