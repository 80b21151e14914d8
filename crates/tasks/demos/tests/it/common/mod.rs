//! A cell without physics: the TCP goes straight to its goal, a closed gripper carries the cube
//! between its fingers, and cubes rest on the support below them.

#![allow(dead_code, reason = "every test file uses a part of it")]
use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::world::{OBJECT_DRAGGED, OBJECT_ENABLED};
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, GripperGoal, Header, Pose, Validate, Wire, WorldState,
};
use robocell_task::{Task, TraceLineText};

pub(crate) const RED: usize = 0;
pub(crate) const BLUE: usize = 1;
pub(crate) const GREEN: usize = 2;
pub(crate) const YELLOW: usize = 3;
pub(crate) const BOTH: [&str; 2] = ["fsm", "ifelse"];
pub(crate) const ALL: [&str; 3] = ["fsm", "ifelse", "bt"];

const STEP_M: f64 = 0.01;
const STEP_WIDTH_M: f64 = 0.004;
const OPEN_M: f64 = 0.08;
const CUBE_M: f64 = 0.05;

pub(crate) struct FakeCell {
    pub(crate) cell: Cell,
    pub(crate) task: Task,
    pub(crate) state: Box<WorldState>,
    pub(crate) decision: Box<Decision>,
    pub(crate) lines: Vec<String>,
    /// Throw the task away before every decision and continue from its checkpoint.
    pub(crate) restart_always: bool,
    /// Fingers find no hold.
    pub(crate) slippery: bool,
    /// Fingers do not open.
    pub(crate) jammed: bool,
    /// The cube between the fingers and where, seen from the TCP.
    pub(crate) grip: Option<(usize, [f64; 3])>,
    status: Box<ArmStatus>,
    gripper: GripperGoal,
    drag_ticks: u32,
}

impl FakeCell {
    pub(crate) fn new(demo: &str, policy: &str, seed: u64) -> Self {
        let cell = Cell::load(&Data::checkout(), demo, seed, None).unwrap();
        let task = demos::policies().task(&cell, policy).unwrap();
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
            let q = spec.pose.rotation.quaternion();
            object.flags = OBJECT_ENABLED;
            object.pose = Pose {
                position: spec.pose.translation.vector.into(),
                orientation_wxyz: [q.w, q.i, q.j, q.k],
            };
        }
        Self {
            cell,
            task,
            state,
            decision: Box::new(Decision::zeroed()),
            lines: Vec::new(),
            restart_always: false,
            slippery: false,
            jammed: false,
            grip: None,
            status: Box::new(ArmStatus::zeroed()),
            gripper: GripperGoal::Keep,
            drag_ticks: 0,
        }
    }

    pub(crate) fn stack(policy: &str) -> Self {
        Self::new("franka-stack", policy, 7)
    }

    /// Decides, then advances the world to the next decision.
    pub(crate) fn step(&mut self) {
        self.decide();
        self.move_on();
    }

    pub(crate) fn decide(&mut self) {
        if self.restart_always {
            self.restart();
        }
        let mut trace: Vec<TraceLineText> = Vec::new();
        self.task.decide(
            &self.state,
            &[Some(&self.status)],
            &mut self.decision,
            &mut trace,
        );
        self.decision.validate().unwrap();
        self.lines.extend(
            trace
                .iter()
                .filter(|l| l.kind.is_for_people())
                .map(|l| l.text.as_str().to_owned()),
        );
    }

    /// A new process takes the checkpoint over.
    pub(crate) fn restart(&mut self) {
        let policy = self.task.policy_name().to_owned();
        self.restart_as(&policy);
    }

    pub(crate) fn restart_as(&mut self, policy: &str) {
        let record = self.task.checkpoint();
        self.task = demos::policies().task(&self.cell, policy).unwrap();
        self.task.restore(&record).unwrap();
        if policy == self.decision.policy.as_str() {
            assert_eq!(
                self.task.checkpoint(),
                record,
                "a checkpoint says all there is to say"
            );
        }
    }

    pub(crate) fn move_on(&mut self) {
        self.move_arm();
        self.move_gripper();
        self.move_cubes();
        self.state.header =
            Header::caused_by::<WorldState>(self.state.header.tick + DECISION_TICKS);
    }

    fn move_arm(&mut self) {
        let goal = self.decision.goals[0];
        self.status.goal_active = u32::from(goal.kind != GoalKind::Hold.code());
        self.status.goal_id = goal.goal_id;
        if goal.kind == GoalKind::Pose.code() {
            let tcp = &mut self.state.arms[0].tcp;
            tcp.orientation_wxyz = goal.target.orientation_wxyz;
            let offset = minus(goal.target.position, tcp.position);
            let share = (STEP_M / norm(offset).max(1e-12)).min(1.0);
            for (p, d) in tcp.position.iter_mut().zip(offset) {
                *p += d * share;
            }
        }
    }

    fn move_gripper(&mut self) {
        match GripperGoal::from_code(self.decision.goals[0].gripper).unwrap() {
            GripperGoal::Keep => {}
            told => self.gripper = told,
        }
        let tcp = self.state.arms[0].tcp.position;
        let gripper = &mut self.state.arms[0].gripper;
        if self.gripper == GripperGoal::Close {
            let near = |i: &usize| norm(minus(self.state.objects[*i].pose.position, tcp)) < 0.02;
            let between = (0..self.cell.objects.len()).find(near);
            let stop = if between.is_some() && !self.slippery {
                CUBE_M
            } else {
                0.0
            };
            gripper.width = (gripper.width - STEP_WIDTH_M).max(stop);
            if self.grip.is_none() && gripper.width <= stop {
                self.grip = between
                    .filter(|_| stop > 0.0)
                    .map(|i| (i, minus(self.state.objects[i].pose.position, tcp)));
            }
        } else if self.gripper == GripperGoal::Open && !self.jammed {
            gripper.width = (gripper.width + STEP_WIDTH_M).min(OPEN_M);
            self.grip = None;
        }
        gripper.held_object = self.grip.map_or(0, |(i, _)| u32::try_from(i).unwrap() + 1);
    }

    fn move_cubes(&mut self) {
        let tcp = self.state.arms[0].tcp;
        self.drag_ticks = self.drag_ticks.saturating_sub(1);
        let mut by_height: Vec<usize> = (0..self.cell.objects.len()).collect();
        by_height.sort_by(|a, b| self.height(*a).total_cmp(&self.height(*b)));
        for i in by_height {
            if let Some((_, offset)) = self.grip.filter(|(held, _)| *held == i) {
                let position = std::array::from_fn(|k| tcp.position[k] + offset[k]);
                self.state.objects[i].pose = Pose {
                    position,
                    ..upright(&tcp)
                };
                continue;
            }
            let floor = self.floor_below(i);
            let object = &mut self.state.objects[i];
            object.pose.position[2] = if floor < 0.0 {
                object.pose.position[2] - 0.1
            } else {
                floor
            };
            if self.drag_ticks == 0 {
                object.flags &= !OBJECT_DRAGGED;
            }
        }
    }

    fn height(&self, cube: usize) -> f64 {
        self.state.objects[cube].pose.position[2]
    }

    fn floor_below(&self, cube: usize) -> f64 {
        let [x, y, z] = self.position(cube);
        let mut floor = if x.abs() < 1.1 && y.abs() < 0.9 {
            CUBE_M / 2.0
        } else {
            -1.0
        };
        for other in (0..self.cell.objects.len()).filter(|o| *o != cube) {
            let [ox, oy, oz] = self.position(other);
            let held = self.grip.is_some_and(|(h, _)| h == other);
            if !held && oz < z && (x - ox).hypot(y - oy) < 0.03 {
                floor = floor.max(oz + CUBE_M);
            }
        }
        floor
    }

    pub(crate) fn position(&self, cube: usize) -> [f64; 3] {
        self.state.objects[cube].pose.position
    }

    /// Puts a cube elsewhere, as the operator does; out of the hand, too.
    pub(crate) fn drag(&mut self, cube: usize, to: [f64; 3]) {
        if self.grip.is_some_and(|(held, _)| held == cube) {
            self.grip = None;
        }
        self.state.objects[cube].pose.position = to;
        self.state.objects[cube].flags |= OBJECT_DRAGGED;
        self.drag_ticks = 5;
    }

    pub(crate) fn phase(&self) -> &str {
        self.decision.phase.as_str()
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    pub(crate) fn placed(&self) -> &[u32] {
        &self.decision.placed[..self.decision.placed_count as usize]
    }

    /// Steps until `there`, for at most `seconds` of simulated time.
    #[track_caller]
    pub(crate) fn run_until(&mut self, seconds: f64, there: impl Fn(&Self) -> bool) {
        let end = self.state.header.sim_time_ns as f64 * 1e-9 + seconds;
        while !there(self) {
            let now = self.state.header.sim_time_ns as f64 * 1e-9;
            assert!(
                now < end,
                "still {} after {seconds} s: {:#?}",
                self.phase(),
                self.lines
            );
            self.step();
        }
    }

    #[track_caller]
    pub(crate) fn run_to_done(&mut self) {
        self.step();
        self.run_until(150.0, |c| c.outcome() != Outcome::Running);
        assert_eq!(self.outcome(), Outcome::Done, "{:#?}", self.lines);
        self.assert_stacked();
    }

    /// Until `cube` is held in `phase`.
    #[track_caller]
    pub(crate) fn run_until_carrying(&mut self, cube: usize, phase: &str) {
        self.run_until(150.0, |c| {
            c.phase() == phase && c.grip.is_some_and(|(i, _)| i == cube)
        });
    }

    #[track_caller]
    pub(crate) fn assert_stacked(&self) {
        assert_eq!(self.placed(), [0, 1, 2, 3]);
        for level in 0..4_u32 {
            let goal = [0.55, 0.20, 0.025 + 0.05 * f64::from(level)];
            let offset = norm(minus(self.position(level as usize), goal));
            assert!(offset < 0.01, "cube {level} is {offset} m off");
        }
    }

    /// The lines that contain `part`.
    pub(crate) fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|l| l.contains(part)).count()
    }

    /// The decision, without the names that differ between kinds of policies.
    pub(crate) fn decided(&self) -> Vec<&str> {
        self.lines
            .iter()
            .filter_map(|l| {
                l.strip_prefix("[decide] -> ")
                    .or_else(|| l.strip_prefix("[select] -> "))
            })
            .collect()
    }
}

/// A held cube turns with the tool, whose z axis points down.
fn upright(tcp: &Pose) -> Pose {
    let [_, x, y, _] = tcp.orientation_wxyz;
    Pose {
        position: [0.0; 3],
        orientation_wxyz: [x, 0.0, 0.0, y],
    }
}

pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub(crate) fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
