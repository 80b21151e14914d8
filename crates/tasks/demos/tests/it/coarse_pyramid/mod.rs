//! The task of the pyramid in a coarse world: situations, and their successors.

mod choice;
mod promises;
mod spy;
mod world;

use std::cell::RefCell;
use std::fmt::Write as _;
use std::hash::{DefaultHasher, Hash, Hasher as _};
use std::rc::Rc;
use std::sync::{Arc, Mutex};

use cell_model::{Cell, Data};
use ipc_types::decision::Outcome;
use ipc_types::{DECISION_TICKS, Decision, GripperGoal, Validate, Wire, WorldState};
use robocell_task::{AnyPolicy as _, Task};

use choice::ARMS;
pub(crate) use choice::Choice;
use promises::Moment;
use spy::{Seen, Spy, Word};
use world::World;

/// Time between two decisions: enough for a phase, or for its longest timeout.
const SOON: u64 = 300 / DECISION_TICKS * DECISION_TICKS;
const LATE: u64 = 5_100 / DECISION_TICKS * DECISION_TICKS;

/// A pyramid of some cubes of the cell file.
pub(crate) struct Setting {
    /// Cubes by their number in the cell file, from 1, and where they are (m).
    pub(crate) cubes: &'static [(usize, [f64; 3])],
    /// Cubes of a complete stack.
    pub(crate) required: usize,
}

/// The task, used again and again: all that matters is in the checkpoint.
struct Bench {
    task: RefCell<Task>,
    window: Arc<Mutex<Seen>>,
    /// The state that physics publishes, as far as it is the same in all situations.
    state: RefCell<Box<WorldState>>,
    /// By arm and node.
    names: Vec<Vec<String>>,
}

impl Bench {
    /// Name of the leaf an arm is at.
    fn leaf(&self, seen: &Seen, arm: usize) -> &str {
        let name = seen.leaf[arm].map(|node| self.names[arm][node].as_str());
        name.unwrap_or("-")
    }
}

/// The data by which two situations are compared.
#[derive(Hash)]
struct Key {
    seen: Seen,
    outcome: u32,
    spots: Vec<[i32; 3]>,
    arms: [ArmKey; ARMS],
}

#[derive(Hash)]
struct ArmKey {
    held: Option<usize>,
    is_open: bool,
    told: u32,
    silent: bool,
    tcp: [i32; 3],
    goal: Option<[i32; 3]>,
    decisions: u32,
}

struct Step {
    what: String,
    before: Option<Rc<Step>>,
}

/// A world and a task in the middle of its job.
#[derive(Clone)]
pub(crate) struct Situation {
    bench: Rc<Bench>,
    record: Rc<Vec<u8>>,
    world: World,
    decision: Box<Decision>,
    seen: Seen,
    /// By arm: decisions since its leaf or its goal changed.
    decisions: [u32; ARMS],
    story: Option<Rc<Step>>,
    wrong: Option<String>,
}

impl Situation {
    pub(crate) fn begin(setting: &Setting) -> Self {
        let cell = cell(setting);
        let names: Vec<String> = setting
            .cubes
            .iter()
            .map(|(c, _)| format!("cube_{c}"))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let (spy, window) = Spy::new(&cell, &names);
        let nodes = spy.describe("json").into_iter();
        let bench = Bench {
            names: nodes
                .map(|g| g.nodes.into_iter().map(|n| n.name).collect())
                .collect(),
            task: RefCell::new(Task::new(&cell, "json", 20.0, Box::new(spy))),
            window,
            state: RefCell::new(Box::new(WorldState::zeroed())),
        };
        let objects: Vec<usize> = setting.cubes.iter().map(|(c, _)| c - 1).collect();
        let places: Vec<[f64; 3]> = setting.cubes.iter().map(|(_, place)| *place).collect();
        let record = Rc::new(bench.task.borrow().checkpoint());
        let mut first = Self {
            bench: Rc::new(bench),
            record,
            world: World::new(&objects, &places),
            decision: Box::new(Decision::zeroed()),
            seen: Seen::default(),
            decisions: [0; ARMS],
            story: None,
            wrong: None,
        };
        first.decide(Choice::Nothing);
        first
    }

    /// The same for situations that are the same, as a hash: there are millions.
    pub(crate) fn key(&self) -> u64 {
        let cubes = 0..self.seen.words.len();
        let key = Key {
            seen: self.seen.clone(),
            outcome: self.decision.outcome,
            spots: cubes.map(|c| rough(self.world.position(c))).collect(),
            arms: std::array::from_fn(|arm| self.arm_key(arm)),
        };
        let mut hasher = DefaultHasher::new();
        key.hash(&mut hasher);
        hasher.finish()
    }

    fn arm_key(&self, arm: usize) -> ArmKey {
        let goal = &self.decision.goals[arm];
        ArmKey {
            held: self.world.held[arm],
            is_open: self.world.is_open(arm),
            told: self.world.told[arm].code(),
            silent: self.world.silent[arm],
            tcp: rough(self.world.arms[arm].tcp.position),
            goal: (goal.kind != 0).then(|| rough(goal.target.position)),
            decisions: self.decisions[arm].min(1),
        }
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    /// All objects with their places and owners.
    pub(crate) fn picture(&self) -> String {
        let Seen { words, owner, .. } = &self.seen;
        let cubes = 0..words.len();
        let spots: Vec<_> = cubes.map(|c| self.world.position(c)).collect();
        let hands = self.world.arms.map(|arm| arm.tcp.position);
        let held = self.world.held;
        format!("owner {owner:?}, {words:?} at {spots:.3?}, {held:?} in hands at {hands:.3?}\n")
    }

    /// The path to here, at most the last `most` steps.
    pub(crate) fn story(&self, most: usize) -> String {
        let mut steps = Vec::new();
        let mut step = self.story.as_ref();
        while let Some(here) = step {
            steps.push(&here.what);
            step = here.before.as_ref();
        }
        let mut story = String::new();
        for what in steps.iter().rev().skip(steps.len().saturating_sub(most)) {
            writeln!(story, "{what}").unwrap();
        }
        story
    }

    /// The situation after `choice`; `None` if it makes no difference.
    pub(crate) fn after(&self, choice: Choice) -> Option<Self> {
        if !self.world.is_possible(choice) {
            return None;
        }
        let mut next = self.clone();
        if let Choice::Led(arm) = choice {
            next.pause(arm);
        }
        let ticks = match choice {
            Choice::Stuck(_) | Choice::HandStuck(_) => LATE,
            _ => SOON,
        };
        next.world.pass(ticks, choice, &self.decision.goals);
        let panel = &mut next.world.panel;
        panel.task_reset += u32::from(choice == Choice::Reset);
        panel.task_paused = 0;
        next.decide(choice);
        Some(next)
    }

    /// The operator takes over and opens the hand of an arm.
    fn pause(&mut self, arm: usize) {
        let panel = &mut self.world.panel;
        panel.task_paused = 1;
        self.decide(Choice::Led(arm));
        let panel = &mut self.world.panel;
        panel.target_arm = u32::try_from(arm).unwrap();
        panel.gripper = GripperGoal::Open.code();
        panel.gripper_seq += 1;
        self.decide(Choice::Led(arm));
        assert_eq!(self.decision.goals[arm].gripper, GripperGoal::Open.code());
    }

    /// The same without further disturbance.
    pub(crate) fn freed(mut self) -> Self {
        let seen = &self.seen;
        let is_stranded = |cube: usize, arm: usize| {
            let others = match seen.words[cube] {
                Word::Available => false,
                Word::Reserved(a) | Word::Carried(a) | Word::Placed(a) => a != arm,
            };
            others || seen.finished[arm]
        };
        if self.world.free(is_stranded) {
            self.tell("freed".to_owned());
        }
        self
    }

    /// The same after another start by the operator.
    pub(crate) fn restarted(mut self) -> Self {
        self.world.panel.task_start += 1;
        self.tell("started again".to_owned());
        self
    }

    /// Where the trees are.
    pub(crate) fn leaves(&self) -> String {
        format!("{:?}", [0, 1].map(|arm| self.bench.leaf(&self.seen, arm)))
    }

    fn tell(&mut self, what: String) {
        let before = self.story.take();
        self.story = Some(Rc::new(Step { what, before }));
    }

    fn decide(&mut self, choice: Choice) {
        let bench = Rc::clone(&self.bench);
        let mut task = bench.task.borrow_mut();
        task.restore(&self.record).unwrap();
        let mut state = bench.state.borrow_mut();
        self.world.write(&mut state);
        if matches!(choice, Choice::Killed | Choice::KilledLost(_)) {
            task.reconcile(&state);
        }
        let before = self.decision.clone();
        let mut lines = Vec::new();
        let heard: [_; ARMS] = std::array::from_fn(|arm| Some(&self.world.status[arm]));
        task.decide(&state, &heard, &mut self.decision, &mut lines);
        self.decision.validate().unwrap();
        self.record = Rc::new(task.checkpoint());
        self.world.tell(&self.decision.goals);
        let seen = bench.window.lock().unwrap().clone();
        for arm in 0..ARMS {
            let same = seen.leaf[arm] == self.seen.leaf[arm]
                && self.decision.goals[arm].goal_id == before.goals[arm].goal_id;
            self.decisions[arm] = if same { self.decisions[arm] + 1 } else { 0 };
        }
        self.seen = seen;
        let leaf: [&str; ARMS] = std::array::from_fn(|arm| bench.leaf(&self.seen, arm));
        let mut what = format!("{:6} {choice:?} -> {leaf:?}", self.world.tick);
        for line in lines.iter().filter(|l| l.kind.is_for_people()) {
            write!(what, " | {}", line.text.as_str()).unwrap();
        }
        self.tell(what);
        let moment = Moment {
            world: &self.world,
            before: &before,
            decision: &self.decision,
            seen: &self.seen,
            leaf,
        };
        self.wrong = moment.wrong().map(|wrong| format!("{wrong}, {leaf:?}"));
    }

    /// The promises that this situation breaks.
    pub(crate) fn wrong(&self) -> Option<&str> {
        self.wrong.as_deref()
    }
}

/// The cell file with fewer cubes.
fn cell(setting: &Setting) -> Cell {
    let data = Data::checkout();
    let file = "cells/franka-pyramid.toml";
    let mut text = data.read(file).unwrap().into_owned();
    let mut replace = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    };
    replace(
        "required_count = 3",
        &format!("required_count = {}", setting.required),
    );
    for order in [[1, 2, 3, 4, 5, 6], [1, 3, 2, 6, 5, 4]] {
        let list = |cubes: &[usize]| {
            let names: Vec<String> = cubes.iter().map(|c| format!("\"cube_{c}\"")).collect();
            format!("order = [{}]", names.join(", "))
        };
        let there = |cube: &usize| setting.cubes.iter().any(|(c, _)| c == cube);
        let kept: Vec<usize> = order.into_iter().filter(there).collect();
        replace(&list(&order), &list(&kept));
    }
    Cell::from_text(&data, "franka-pyramid", file, &text, 0, None).unwrap()
}

/// A position in steps of 2 cm.
#[allow(clippy::cast_possible_truncation, reason = "a table is not that large")]
fn rough(position: [f64; 3]) -> [i32; 3] {
    position.map(|x| (x / 0.02 + 1.0e-6).round() as i32)
}
