//! A world in which everything happens between two decisions, or not at all.

mod choice;

use std::sync::Arc;

use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, GripperGoal, Header, Pose, Validate, Wire, WorldState,
};

pub(crate) use choice::Choice;

const CUBES: usize = 2;
/// How often something is tried, fewer times than in the cell file.
const ATTEMPTS: u32 = 2;
const CUBE_M: f64 = 0.05;
const OPEN_M: f64 = 0.08;
const GOAL: [f64; 2] = [0.55, 0.20];
/// Where a lost cube ends up, and out of reach.
const AWAY: [[f64; 3]; CUBES] = [[0.45, -0.05, 0.025], [0.62, -0.05, 0.025]];
const FAR: [[f64; 3]; CUBES] = [[1.0, 0.5, 0.025], [1.0, 0.65, 0.025]];
/// Time between two decisions: enough for a phase, or for its longest timeout.
const SOON: u64 = 600 / DECISION_TICKS * DECISION_TICKS;
const LATE: u64 = 5_100 / DECISION_TICKS * DECISION_TICKS;

/// Where a cube is, as far as it matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Spot {
    Spawn(usize),
    Goal(usize),
    Hand,
    Away,
    Far,
    Other,
}

/// The data by which two situations are compared.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    phase: String,
    outcome: u32,
    reason: String,
    spots: [Spot; CUBES],
    is_open: bool,
    at_target: bool,
    opening: bool,
    decisions_in_phase: u32,
    losses: u32,
    /// By cube.
    misplaced: [u32; CUBES],
}

/// A world and a task in the middle of its job.
#[derive(Clone)]
pub(crate) struct Situation {
    policy: &'static str,
    cell: Arc<Cell>,
    record: Vec<u8>,
    state: Box<WorldState>,
    status: Box<ArmStatus>,
    decision: Box<Decision>,
    held: Option<usize>,
    at_target: bool,
    decisions_in_phase: u32,
    /// Drops since a cube was last set down.
    losses: u32,
    /// The hand was commanded to open and has not opened: its fingers are stuck. The command
    /// may be repeated.
    opening: bool,
    /// The cube that was released last.
    released: Option<usize>,
    /// By cube: how often in a row it was not where it had been set down.
    misplaced: [u32; CUBES],
    story: Vec<String>,
}

impl Situation {
    pub(crate) fn begin(policy: &str) -> Self {
        let data = Data::checkout();
        let text = data.read("cells/franka-stack.toml").unwrap();
        let all = r#"["red_cube", "blue_cube", "green_cube", "yellow_cube"]"#;
        assert!(text.contains(all));
        let text = text.replace(all, r#"["red_cube", "blue_cube"]"#);
        // Counts are part of a situation, so a small limit keeps their number small.
        let five = "max_attempts = 5";
        assert!(text.contains(five));
        let text = text.replace(five, &format!("max_attempts = {ATTEMPTS}"));
        let file = "cells/franka-stack.toml";
        let cell = Cell::from_text(&data, "franka-stack", file, &text, 0, None).unwrap();
        let policy = ["fsm", "ifelse", "bt"]
            .into_iter()
            .find(|p| *p == policy)
            .unwrap();
        let mut state = Box::new(WorldState::zeroed());
        state.header = Header::caused_by::<WorldState>(0);
        state.arm_count = 1;
        state.arms[0].tcp = Pose {
            position: [0.4, 0.0, 0.4],
            orientation_wxyz: [0.0, 1.0, 0.0, 0.0],
        };
        state.arms[0].gripper.width = OPEN_M;
        state.object_count = u32::try_from(cell.objects.len()).unwrap();
        for (object, spec) in state.objects.iter_mut().zip(&cell.objects) {
            object.flags = OBJECT_ENABLED;
            object.pose = upright(spec.pose.translation.vector.into());
        }
        let mut first = Self {
            policy,
            record: demos::policies().task(&cell, policy).unwrap().checkpoint(),
            cell: Arc::new(cell),
            state,
            status: Box::new(ArmStatus::zeroed()),
            decision: Box::new(Decision::zeroed()),
            held: None,
            at_target: false,
            decisions_in_phase: 0,
            losses: 0,
            opening: false,
            released: None,
            misplaced: [0; CUBES],
            story: Vec::new(),
        };
        first.decide(Choice::Nothing);
        first
    }

    pub(crate) fn key(&self) -> Key {
        Key {
            phase: self.decision.phase.as_str().to_owned(),
            outcome: self.decision.outcome,
            reason: self.decision.reason.as_str().to_owned(),
            spots: std::array::from_fn(|cube| self.spot(cube)),
            is_open: self.state.arms[0].gripper.width >= OPEN_M,
            at_target: self.at_target,
            opening: self.opening,
            decisions_in_phase: self.decisions_in_phase.min(3),
            losses: self.losses.min(2 * ATTEMPTS),
            misplaced: self.misplaced.map(|times| times.min(ATTEMPTS)),
        }
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    pub(crate) fn story(&self) -> &[String] {
        &self.story
    }

    /// The situation after `choice`; `None` if it makes no difference.
    pub(crate) fn after(&self, choice: Choice) -> Option<Self> {
        if !self.is_possible(choice) {
            return None;
        }
        let mut next = self.clone();
        if choice == Choice::Led {
            next.pause();
        }
        let told = GripperGoal::from_code(next.decision.goals[0].gripper).unwrap();
        let (mut ticks, mut is_reset) = (SOON, false);
        match choice {
            Choice::ArmStuck | Choice::GripperStuck => ticks = LATE,
            Choice::Lost | Choice::KilledLost | Choice::Led => next.let_go(true),
            Choice::Moved(cube) => next.put(cube, AWAY[cube]),
            Choice::Taken(cube) => next.put(cube, FAR[cube]),
            Choice::Reset => is_reset = true,
            Choice::Nothing | Choice::Slippery | Choice::Killed => {}
        }
        next.move_arm(choice == Choice::ArmStuck);
        match told {
            GripperGoal::Close => next.close(matches!(
                choice,
                Choice::Slippery | Choice::Lost | Choice::KilledLost
            )),
            GripperGoal::Open if choice != Choice::GripperStuck => next.open(),
            GripperGoal::Open | GripperGoal::Keep => {}
        }
        next.settle();
        next.state.header = Header::caused_by::<WorldState>(self.state.header.tick + ticks);
        next.state.panel.task_reset += u32::from(is_reset);
        next.state.panel.task_paused = 0;
        next.story.push(format!("{choice:?}"));
        next.decide(choice);
        Some(next)
    }

    /// The operator takes over and opens the hand.
    fn pause(&mut self) {
        self.state.panel.task_paused = 1;
        self.decide(Choice::Led);
        self.state.panel.gripper = GripperGoal::Open.code();
        self.state.panel.gripper_seq += 1;
        self.decide(Choice::Led);
        let gripper = self.decision.goals[0].gripper;
        assert_eq!(gripper, GripperGoal::Open.code());
    }

    /// The same with every cube within reach.
    pub(crate) fn freed(mut self) -> Self {
        for (cube, away) in AWAY.into_iter().enumerate() {
            if self.spot(cube) == Spot::Far {
                self.put(cube, away);
            }
        }
        self
    }

    /// The same after another start by the operator.
    pub(crate) fn restarted(mut self) -> Self {
        self.state.panel.task_start += 1;
        self.story.push("started again".to_owned());
        self
    }

    fn is_possible(&self, choice: Choice) -> bool {
        let told = GripperGoal::from_code(self.decision.goals[0].gripper).unwrap();
        match choice {
            Choice::Nothing | Choice::ArmStuck | Choice::Reset | Choice::Killed => true,
            Choice::GripperStuck => {
                told == GripperGoal::Open && self.state.arms[0].gripper.width < OPEN_M
            }
            Choice::Slippery => told == GripperGoal::Close && self.held.is_none(),
            Choice::Lost | Choice::KilledLost | Choice::Led => self.held.is_some(),
            Choice::Moved(cube) => self.held != Some(cube) && self.spot(cube) != Spot::Away,
            Choice::Taken(cube) => self.held != Some(cube) && self.spot(cube) != Spot::Far,
        }
    }

    fn decide(&mut self, choice: Choice) {
        let mut task = demos::policies().task(&self.cell, self.policy).unwrap();
        task.restore(&self.record).unwrap();
        let before = self.decision.clone();
        let mut lines = Vec::new();
        let gripper = &mut self.state.arms[0].gripper;
        gripper.held_object = self.held.map_or(0, |c| u32::try_from(c + 1).unwrap());
        if matches!(choice, Choice::Killed | Choice::KilledLost) {
            task.reconcile(&self.state);
        }
        task.decide(
            &self.state,
            &[Some(&self.status)],
            &mut self.decision,
            &mut lines,
        );
        self.decision.validate().unwrap();
        let said = lines.iter().filter(|l| l.kind.is_for_people());
        self.story.extend(said.map(|l| l.text.as_str().to_owned()));
        self.record = task.checkpoint();
        let is_new =
            before.phase != self.decision.phase || before.phase_entry != self.decision.phase_entry;
        self.decisions_in_phase = if is_new {
            0
        } else {
            self.decisions_in_phase + 1
        };
        self.losses += self.decision.drops.saturating_sub(before.drops);
        if self.decision.phase.as_str() == "RETRACT" {
            self.losses = 0;
        }
        if choice == Choice::Reset {
            (self.losses, self.misplaced) = (0, [0; CUBES]);
        }
        self.count_misplaced(&before);
        self.assert_keeps_hold(&before);
    }

    /// The count that the policies have, too, and at which they fail the job.
    fn count_misplaced(&mut self, before: &Decision) {
        let (was, is) = (before.phase.as_str(), self.decision.phase.as_str());
        if is == "RELEASE" && self.held.is_some() {
            self.released = self.held;
        }
        if let Some(cube) = self.released.filter(|_| was == "RETRACT" && is != was) {
            let stands = self.spot(cube) == Spot::Goal(cube);
            self.misplaced[cube] = if stands { 0 } else { self.misplaced[cube] + 1 };
        }
    }

    /// The promise: a held cube is released on purpose only.
    fn assert_keeps_hold(&mut self, before: &Decision) {
        let opens = self.decision.goals[0].gripper == GripperGoal::Open.code();
        let closes = self.decision.goals[0].gripper == GripperGoal::Close.code();
        self.opening &= self.held.is_some() && !closes;
        if self.held.is_none() || !opens {
            return;
        }
        let goes_on = self.opening;
        self.opening = true;
        let on_purpose = self.decision.phase.as_str() == "RELEASE"
            || goes_on
            || self.decision.drops > before.drops
            || self.outcome() == Outcome::Paused;
        assert!(
            on_purpose,
            "{} opens the gripper around a cube in {}: {:#?}",
            self.policy, self.decision.phase, self.story
        );
    }

    fn move_arm(&mut self, stuck: bool) {
        let goal = self.decision.goals[0];
        self.status.goal_active = u32::from(goal.kind != GoalKind::Hold.code());
        self.status.goal_id = goal.goal_id;
        self.at_target = goal.kind != GoalKind::Pose.code();
        if goal.kind == GoalKind::Pose.code() && !stuck {
            self.state.arms[0].tcp = goal.target;
            self.at_target = true;
        }
        if let Some(cube) = self.held {
            let tcp = self.state.arms[0].tcp.position;
            self.state.objects[cube].pose = upright(tcp);
        }
    }

    fn close(&mut self, slippery: bool) {
        let tcp = self.state.arms[0].tcp.position;
        let near = |cube: &usize| distance(self.position(*cube), tcp) < 0.02;
        if self.held.is_none() && !slippery {
            self.held = (0..CUBES).find(near);
        }
        self.state.arms[0].gripper.width = if self.held.is_some() { CUBE_M } else { 0.0 };
    }

    fn open(&mut self) {
        self.let_go(false);
        self.state.arms[0].gripper.width = OPEN_M;
    }

    /// The held cube drops straight down, or tumbles away.
    fn let_go(&mut self, tumbles: bool) {
        let Some(cube) = self.held.take() else {
            return;
        };
        if tumbles {
            self.put(cube, AWAY[cube]);
        }
    }

    fn put(&mut self, cube: usize, to: [f64; 3]) {
        self.state.objects[cube].pose = upright(to);
    }

    /// Loose cubes rest on the table or on another cube.
    fn settle(&mut self) {
        let held = self.held;
        for cube in (0..CUBES).filter(|c| held != Some(*c)) {
            let [x, y, z] = self.position(cube);
            let other = 1 - cube;
            let [ox, oy, oz] = self.position(other);
            let on_top = self.held != Some(other) && (x - ox).hypot(y - oy) < 0.03 && oz < z;
            let height = if on_top { oz + CUBE_M } else { CUBE_M / 2.0 };
            self.put(cube, [x, y, height]);
        }
    }

    fn position(&self, cube: usize) -> [f64; 3] {
        self.state.objects[cube].pose.position
    }

    fn spot(&self, cube: usize) -> Spot {
        let position = self.position(cube);
        let is_at = |place: [f64; 3]| distance(position, place) < 0.02;
        if self.held == Some(cube) {
            return Spot::Hand;
        }
        for level in 0..CUBES {
            let z = CUBE_M * (level as f64 + 0.5);
            if is_at([GOAL[0], GOAL[1], z]) {
                return Spot::Goal(level);
            }
            let spawn = self.cell.objects[level].pose.translation.vector;
            if is_at(spawn.into()) {
                return Spot::Spawn(level);
            }
        }
        match cube {
            c if is_at(AWAY[c]) => Spot::Away,
            c if is_at(FAR[c]) => Spot::Far,
            _ => Spot::Other,
        }
    }
}

fn upright(position: [f64; 3]) -> Pose {
    Pose {
        position,
        ..Pose::IDENTITY
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    squares.sqrt()
}
