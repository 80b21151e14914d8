//! The coarse cell.

use cell_model::{Cell, Data};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, GripperGoal, Header, Pose, Validate, Wire, WorldState,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use robocell_task::{Task, TraceLineText};

/// The tool's way in one decision (m).
const STEP_M: f64 = 0.01;
/// The belt's way in one decision (m).
const BELT_M: f64 = 0.003;
/// The cup holds a bin that is this near to its goal (m).
const GRIP_M: f64 = 0.006;

pub(crate) struct PalletCell {
    pub(crate) state: Box<WorldState>,
    pub(crate) decision: Box<Decision>,
    pub(crate) lines: Vec<String>,
    /// Throw the task away before every decision and continue from its checkpoint.
    pub(crate) restarts: bool,
    /// Suction finds no hold.
    pub(crate) slippery: bool,
    /// The bin on the cup, and where, seen from the tool.
    pub(crate) held: Option<(usize, Isometry3<f64>)>,
    /// Bins that were released in the jig.
    pub(crate) flips: Vec<usize>,
    cell: Cell,
    task: Task,
    status: Box<ArmStatus>,
    /// Which come upside down.
    lies: Vec<bool>,
    suction: bool,
}

impl PalletCell {
    pub(crate) fn new(bins: u32, lies: &[bool]) -> Self {
        let mut cell = Cell::load(&Data::checkout(), "ur10-palletize", 1, None).unwrap();
        cell.limit_bins(bins).unwrap();
        let mut state = Box::new(WorldState::zeroed());
        state.header = Header::caused_by::<WorldState>(0);
        state.arm_count = 1;
        state.arms[0].tcp = home(&cell);
        state.object_count = u32::try_from(cell.objects.len()).unwrap();
        for object in &mut state.objects {
            object.pose = Pose::IDENTITY;
        }
        Self {
            task: demos::policies().task(&cell, "table").unwrap(),
            cell,
            state,
            decision: Box::new(Decision::zeroed()),
            lines: Vec::new(),
            restarts: false,
            slippery: false,
            held: None,
            flips: Vec::new(),
            status: Box::new(ArmStatus::zeroed()),
            lies: lies.to_vec(),
            suction: false,
        }
    }

    /// Ticks so far.
    pub(crate) fn now(&self) -> u64 {
        self.state.header.tick
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    pub(crate) fn placed(&self) -> &[u32] {
        &self.decision.placed[..self.decision.placed_count as usize]
    }

    pub(crate) fn said(&self, words: &str) -> bool {
        self.lines.iter().any(|line| line.contains(words))
    }

    /// States entered so far.
    pub(crate) fn states(&self) -> Vec<&str> {
        let lines = self.lines.iter();
        let entered = lines.filter_map(|line| line.split_once(" -> ")?.1.split_once(" ("));
        entered.map(|(state, _)| state).collect()
    }

    pub(crate) fn obstacle_bit(&self, name: &str) -> u64 {
        let at = self.cell.obstacles().position(|f| f.name == name);
        1 << at.unwrap()
    }

    /// Puts a bin down.
    pub(crate) fn put(&mut self, bin: usize, position: [f64; 3], upside_down: bool) {
        let object = &mut self.state.objects[bin];
        object.flags = OBJECT_ENABLED;
        object.pose.position = position;
        object.pose.orientation_wxyz = if upside_down {
            [0.0, 1.0, 0.0, 0.0]
        } else {
            [1.0, 0.0, 0.0, 0.0]
        };
    }

    /// Turns a bin about the vertical axis (rad).
    pub(crate) fn turn(&mut self, bin: usize, yaw: f64) {
        let q = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        self.state.objects[bin].pose.orientation_wxyz = [q.w, q.i, q.j, q.k];
    }

    /// A new task without a checkpoint.
    pub(crate) fn forget(&mut self) {
        self.task = demos::policies().task(&self.cell, "table").unwrap();
    }

    /// Until done or given up, or for so many decisions.
    pub(crate) fn run(&mut self, decisions: usize) {
        for _ in 0..decisions {
            self.step();
            if !matches!(self.outcome(), Outcome::Running) {
                return;
            }
        }
    }

    pub(crate) fn run_until(&mut self, phase: &str) {
        for _ in 0..10_000 {
            self.step();
            if self.decision.phase.as_str() == phase {
                return;
            }
        }
        panic!("never in {phase}: {:#?}", self.lines);
    }

    /// One decision, and its effects.
    pub(crate) fn step(&mut self) {
        self.decide();
        self.follow();
        self.grip();
        self.belt();
        self.state.header.tick += DECISION_TICKS;
    }

    fn decide(&mut self) {
        if self.restarts {
            let record = self.task.checkpoint();
            self.forget();
            self.task.restore(&record).unwrap();
        }
        let mut trace: Vec<TraceLineText> = Vec::new();
        self.task.decide(
            &self.state,
            &[Some(&self.status)],
            &mut self.decision,
            &mut trace,
        );
        self.decision.validate().unwrap();
        let people = trace.iter().filter(|line| line.kind.is_for_people());
        let texts = people.map(|line| line.text.as_str().to_owned());
        self.lines
            .extend(texts.filter(|line| !line.starts_with("[task]")));
    }

    /// The tool turns at once and moves straight to its goal.
    fn follow(&mut self) {
        let goal = self.decision.goals[0];
        self.status.goal_id = goal.goal_id;
        self.status.goal_active = 1;
        if goal.kind == GoalKind::Hold.code() {
            return;
        }
        let tcp = &mut self.state.arms[0].tcp;
        let (from, to) = (
            Vector3::from(tcp.position),
            Vector3::from(goal.target.position),
        );
        let way = to - from;
        tcp.position = if way.norm() <= STEP_M {
            goal.target.position
        } else {
            (from + way.normalize() * STEP_M).into()
        };
        tcp.orientation_wxyz = goal.target.orientation_wxyz;
    }

    fn grip(&mut self) {
        let tool = isometry(&self.state.arms[0].tcp);
        let goal = GripperGoal::from_code(self.decision.goals[0].gripper).unwrap();
        let was = self.suction;
        if goal != GripperGoal::Keep {
            self.suction = goal == GripperGoal::Close;
        }
        if self.suction && !was {
            self.held = self.at_cup(&tool);
            if self.held.is_none() {
                self.state.arms[0].gripper.refusals += 1;
            }
        }
        if !self.suction
            && let Some((bin, _)) = self.held.take()
        {
            self.let_go(bin);
        }
        if let Some((bin, grip)) = self.held {
            self.state.objects[bin].pose = wire(&(tool * grip));
        }
        let gripper = &mut self.state.arms[0].gripper;
        gripper.attached = u32::from(self.held.is_some());
        gripper.held_object = self
            .held
            .map_or(0, |(bin, _)| u32::try_from(bin + 1).unwrap());
    }

    /// The bin whose floor the cup touches, from the inside or the outside.
    fn at_cup(&self, tool: &Isometry3<f64>) -> Option<(usize, Isometry3<f64>)> {
        let objects = self.state.objects().iter().enumerate();
        let mut there = objects.filter(|(_, object)| object.flags & OBJECT_ENABLED != 0);
        let found = there.find_map(|(bin, object)| {
            let pose = isometry(&object.pose);
            let cup = pose.inverse_transform_point(&tool.translation.vector.into());
            let near =
                |floor: f64| (cup.z - floor).abs() < GRIP_M && cup.xy().coords.norm() < GRIP_M;
            (near(-0.0675) || near(-0.0625)).then(|| (bin, tool.inverse() * pose))
        });
        found.filter(|_| !self.slippery)
    }

    /// A bin stays where it was released; in the jig it turns level.
    fn let_go(&mut self, bin: usize) {
        let [x, y, _] = self.state.objects[bin].pose.position;
        if (x - 0.79).hypot(y - 0.74) < 0.2 {
            self.flips.push(bin);
            self.put(bin, [0.78, 0.75, -0.0275], false);
            self.turn(bin, 0.775);
        } else {
            self.state.objects[bin].pose.position[2] -= 0.002;
        }
    }

    /// Brings the requested bins, and carries those on the belt.
    fn belt(&mut self) {
        let came = self.state.equipment.bins_supplied;
        if self.decision.io.add_bin > came {
            self.state.equipment.bins_supplied += 1;
            let bin = came as usize;
            if let Some(lies) = self.lies.get(bin).copied() {
                self.put(bin, [0.05, 1.5, -0.151], lies);
            }
        }
        if self.decision.io.conveyor_running == 0 {
            return;
        }
        let held = self.held.map(|(bin, _)| bin);
        for (bin, object) in self.state.objects.iter_mut().enumerate() {
            let [x, y, z] = &mut object.pose.position;
            if Some(bin) != held && x.abs() < 0.33 && *y > 0.3 && *z < -0.1 {
                *y -= BELT_M;
            }
        }
    }
}

fn home(cell: &Cell) -> Pose {
    let arm = &cell.arms[0];
    let joints = arm.robot.with_arm_positions(&arm.home);
    wire(&arm.robot.frame_pose(arm.robot.tcp_frame, &joints).unwrap())
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    Isometry3::from_parts(
        Translation3::from(pose.position),
        UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
    )
}

fn wire(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation;
    Pose {
        position: pose.translation.vector.into(),
        orientation_wxyz: [q.w, q.i, q.j, q.k],
    }
}
