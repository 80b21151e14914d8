//! The coarse world: the cup moves to its goal at an even pace, suction takes the bin when it
//! is near, and too much weight breaks it off.

use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::equipment::{BreakCause, BreakLimit};
use ipc_types::trace::TraceKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{Decision, GripperGoal, Pose, Wire, WorldState};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use robocell_skills::{geometry, pose};
use robocell_task::Task;
use robocell_task::output::TraceLineText;

pub(super) const BIN: usize = 0;
const DEMO: &str = "ur10-fill-bin";
const NAME: &str = "matrix";
/// Distance that the cup moves between two decisions (m).
const PACE_M: f64 = 0.01;

pub(super) struct World {
    pub(super) cell: Cell,
    pub(super) task: Task,
    pub(super) state: Box<WorldState>,
    pub(super) decision: Decision,
    pub(super) lines: Vec<TraceLineText>,
    /// The bin in the frame of the cup.
    pub(super) held: Option<Isometry3<f64>>,
    pub(super) drops: u32,
    pub(super) load_kg: f64,
    /// Suction does not work.
    pub(super) leaky: bool,
    /// Pose of the bin after its fall.
    pub(super) fallen: Isometry3<f64>,
    /// It falls when it is released, too.
    pub(super) falls: bool,
    /// A new task is restored from the checkpoint before every decision.
    pub(super) restarts: bool,
}

pub(super) fn at(position: [f64; 3], turn: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::from(position),
        UnitQuaternion::from_scaled_axis(Vector3::from(turn)),
    )
}

/// On its end, opening towards -x: how it falls off its stand.
pub(super) fn on_its_end() -> Isometry3<f64> {
    at(
        [-0.17, 0.81, -0.44],
        [0.0, -std::f64::consts::FRAC_PI_2, 0.0],
    )
}

impl World {
    pub(super) fn new() -> Self {
        let cell = Cell::load(&Data::checkout(), DEMO, 1, None).unwrap();
        let mut state = Box::new(WorldState::zeroed());
        (state.arm_count, state.object_count) = (1, 101);
        for (object, spec) in state.objects.iter_mut().zip(&cell.objects) {
            object.pose = pose::wire(&spec.pose);
            object.flags = if spec.parked { 0 } else { OBJECT_ENABLED };
        }
        state.arms[0].tcp = Pose {
            position: [0.0, 0.6, 0.5],
            orientation_wxyz: geometry::straight_down_by_x(0.0),
        };
        (state.panel.task_start, state.panel.task_started) = (1, 1);
        Self {
            task: crate::policies().task(&cell, NAME).unwrap(),
            cell,
            state,
            decision: Decision::zeroed(),
            lines: Vec::new(),
            held: None,
            drops: 0,
            load_kg: 0.0,
            leaky: false,
            fallen: on_its_end(),
            falls: false,
            restarts: false,
        }
    }

    pub(super) fn restart(&mut self) {
        let record = self.task.checkpoint();
        self.task = crate::policies().task(&self.cell, NAME).unwrap();
        self.task.restore(&record).unwrap();
    }

    /// Decisions of that many ticks are missed, and the task is started again.
    pub(super) fn miss(&mut self, ticks: u64) {
        self.state.header.tick += ticks;
        self.restart();
        self.task.reconcile(&self.state);
    }

    /// The operator commands the gripper.
    pub(super) fn ask(&mut self, goal: GripperGoal) {
        let panel = &mut self.state.panel;
        (panel.gripper, panel.gripper_seq) = (goal.code(), panel.gripper_seq + 1);
    }

    /// The start event was given that often.
    pub(super) fn start(&mut self, times: u32) {
        let panel = &mut self.state.panel;
        (panel.task_start, panel.task_started) = (times, times.min(1));
    }

    pub(super) fn step(&mut self) {
        if self.restarts {
            self.restart();
        }
        let lines = &mut self.lines;
        self.task
            .decide(&self.state, &[None], &mut self.decision, lines);
        ipc_types::Validate::validate(&self.decision).unwrap();
        self.move_arm();
        self.suck();
        self.fill();
        self.state.header.tick += 10;
    }

    pub(super) fn move_arm(&mut self) {
        let goal = self.decision.goals[0];
        let tcp = self.state.arms[0].tcp;
        if goal.kind == GoalKind::Pose.code() {
            let part = (PACE_M / pose::distance(&goal.target, &tcp).max(1.0e-9)).min(1.0);
            self.state.arms[0].tcp = pose::between(&tcp, &goal.target, part);
        }
        if let Some(held) = self.held {
            let bin = pose::isometry(&self.state.arms[0].tcp) * held;
            self.state.objects[BIN].pose = pose::wire(&bin);
        }
    }

    pub(super) fn suck(&mut self) {
        let tcp = pose::isometry(&self.state.arms[0].tcp);
        let bin = pose::isometry(&self.state.objects[BIN].pose);
        let gripper = &mut self.state.arms[0].gripper;
        match GripperGoal::from_code(self.decision.goals[0].gripper).unwrap() {
            GripperGoal::Keep => {}
            GripperGoal::Open => {
                (gripper.suction, gripper.attached, gripper.held_object) = (0, 0, 0);
                if self.held.take().is_some() && self.falls {
                    self.state.objects[BIN].pose = pose::wire(&self.fallen);
                }
            }
            GripperGoal::Close if gripper.suction == 1 => {}
            GripperGoal::Close => {
                gripper.suction = 1;
                let near = (tcp.translation.vector - bin.translation.vector).norm() < 0.16;
                if self.leaky || !near {
                    gripper.refusals += 1;
                } else {
                    (gripper.attached, gripper.held_object) = (1, 1);
                    self.held = Some(tcp.inverse() * bin);
                }
            }
        }
    }

    /// Three parts of 0.1 kg for a request; 50 N break the grip.
    pub(super) fn fill(&mut self) {
        self.load_kg += 0.3 * f64::from(self.decision.io.drop_parts - self.drops);
        self.drops = self.decision.io.drop_parts;
        if self.held.is_some() && (0.6 + self.load_kg) * 9.81 > 50.0 {
            self.break_grip();
        }
    }

    pub(super) fn break_grip(&mut self) {
        let gripper = &mut self.state.arms[0].gripper;
        (gripper.attached, gripper.held_object) = (0, 0);
        gripper.breaks += 1;
        gripper.break_limit = BreakLimit::Force.code();
        gripper.break_cause = BreakCause::Weight.code();
        self.held = None;
        self.load_kg = 0.0;
        self.state.objects[BIN].pose = pose::wire(&self.fallen);
    }

    pub(super) fn run_until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        for _ in 0..12_000 {
            self.step();
            if done(self) {
                return;
            }
        }
        panic!("never {what}: {:#?}", self.log());
    }

    pub(super) fn run_to(&mut self, outcome: Outcome) {
        self.run_until("ends", |world| world.decision.outcome == outcome.code());
    }

    pub(super) fn phase(&self) -> &str {
        self.decision.phase.as_str()
    }

    pub(super) fn log(&self) -> Vec<&str> {
        let said =
            |line: &&TraceLineText| matches!(line.kind, TraceKind::Log | TraceKind::Transition);
        let lines = self.lines.iter().filter(said);
        lines.map(|line| line.text.as_str()).collect()
    }

    pub(super) fn says(&self, what: &str) -> usize {
        self.log().iter().filter(|line| line.contains(what)).count()
    }
}
