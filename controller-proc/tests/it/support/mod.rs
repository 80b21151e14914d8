//! A UR10 in a plain world in which the drives make the commanded motion exactly.

#![allow(
    dead_code,
    clippy::expect_used,
    reason = "each test uses its own part, and a test fails by panicking"
)]

use cell_model::{Cell, Data, Robot};
use controller_proc::cycle::Cycle;
use ipc_types::decision::GoalKind;
use ipc_types::world::OBJECT_ENABLED;
use ipc_types::{ArmCommand, ArmStatus, Decision, GripperGoal, Header, Pose, Wire, WorldState};
use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

/// Age at which a decision counts as lost (ticks).
pub(crate) const LIMIT: u64 = 30;

/// A UR10 among bins, fixtures besides its baseand no other arm.
const CELL: &str = r#"
description = "a UR10"
policies = ["follow"]
default_policy = "follow"
time_limit_s = 100.0
[camera]
eye_m = [2.0, 2.0, 1.0]
target_m = [0.0, 0.0, 0.0]
[[arm]]
name = "arm"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]
[[fixture]]
name = "dome"
shape = { kind = "sphere", radius_m = 0.2 }
position_m = [0.73, 0.76, -0.13]
friction = 0.5
obstacle = true
colour = [0.5, 0.5, 0.5]
[[fixture]]
name = "barrier"
shape = { kind = "capsule", radius_m = 0.2, height_m = 0.4 }
position_m = [0.8, 0.1, -0.2]
friction = 0.5
obstacle = true
colour = [0.5, 0.5, 0.5]
[[object]]
name = "bin"
count = 40
shape = { kind = "bin", size_m = [0.30, 0.20, 0.147], wall_m = 0.005 }
mass_kg = 0.6
friction = 0.6
position_m = [0.0, 3.0, 0.5]
pitch_m = [0.0, 0.5, 0.0]
obstacle = true
colour = [0.3, 0.5, 0.8]
[task]
kind = "reach"
"#;

/// The tool's x axis down, its y axis along the world's x.
pub(crate) fn down(yaw: f64) -> UnitQuaternion<f64> {
    let turn = UnitQuaternion::from_euler_angles(0.0, std::f64::consts::FRAC_PI_2, 0.0);
    UnitQuaternion::from_euler_angles(0.0, 0.0, yaw) * turn
}

pub(crate) struct Bench {
    pub(crate) cell: Cell,
    pub(crate) cycle: Cycle,
    pub(crate) state: Box<WorldState>,
    pub(crate) decision: Box<Decision>,
    pub(crate) command: ArmCommand,
    pub(crate) status: ArmStatus,
    pub(crate) violations: usize,
}

impl Bench {
    pub(crate) fn new() -> Self {
        let cell =
            Cell::from_text(&Data::checkout(), "test", "test.toml", CELL, 1, None).expect("a cell");
        let mut state = Box::new(WorldState::zeroed());
        state.header.generation = 1;
        state.arm_count = 1;
        state.object_count = u32::try_from(cell.objects.len()).expect("few objects");
        for (slot, object) in state.objects.iter_mut().zip(&cell.objects) {
            slot.flags = OBJECT_ENABLED;
            slot.pose = wire(&object.pose);
        }
        let arm = &mut state.arms[0];
        arm.joint_count = 6;
        for (slot, home) in cell.arms[0].home.iter().enumerate() {
            arm.joint_positions[slot] = *home;
            arm.setpoint_positions[slot] = *home;
        }
        let mut decision = Box::new(Decision::zeroed());
        decision.arm_count = 1;
        decision.goals[0].target = Pose::IDENTITY;
        let mut bench = Self {
            cycle: Cycle::new(&cell, 0).expect("a controller"),
            cell,
            state,
            decision,
            command: ArmCommand::zeroed(),
            status: ArmStatus::zeroed(),
            violations: 0,
        };
        bench.measure();
        bench
    }

    pub(crate) fn robot(&self) -> &Robot {
        &self.cell.arms[0].robot
    }

    /// A new goal; everything that was asked before stays.
    pub(crate) fn goal(&mut self, position: [f64; 3], orientation: UnitQuaternion<f64>) {
        let goal = &mut self.decision.goals[0];
        goal.goal_id += 1;
        goal.kind = GoalKind::Pose.code();
        let at = Isometry3::from_parts(position.into(), orientation);
        goal.target = wire(&at);
    }

    /// Joints to reach for.
    pub(crate) fn joints(&mut self, joints: [f64; 6]) {
        self.posture(joints);
        self.decision.goals[0].goal_id += 1;
        self.decision.goals[0].kind = GoalKind::Joints.code();
    }

    pub(crate) fn gripper(&mut self, gripper: GripperGoal) {
        self.decision.goals[0].gripper = gripper.code();
    }

    /// Comes along `direction`, scaled by its length (m).
    pub(crate) fn corridor(&mut self, direction: [f64; 3], std_dev: f64) {
        self.decision.goals[0].approach = direction;
        self.decision.goals[0].approach_std_dev = std_dev;
    }

    pub(crate) fn posture(&mut self, posture: [f64; 6]) {
        self.decision.goals[0].has_posture = 1;
        self.decision.goals[0].posture[..6].copy_from_slice(&posture);
    }

    /// Puts an object somewhere, upright.
    pub(crate) fn put(&mut self, object: usize, position: [f64; 3]) {
        self.state.objects[object].pose = wire(&Isometry3::from_parts(
            position.into(),
            UnitQuaternion::identity(),
        ));
    }

    /// Attaches an object to the tool at `pose` in the tool frame.
    pub(crate) fn attach(&mut self, object: usize, pose: &Isometry3<f64>) {
        self.state.arms[0].gripper.attached = 1;
        self.state.arms[0].gripper.held_object = u32::try_from(object + 1).expect("small");
        self.state.objects[object].pose = wire(&(self.tool() * pose));
    }

    pub(crate) fn detach(&mut self) {
        self.state.arms[0].gripper.attached = 0;
        self.state.arms[0].gripper.held_object = 0;
    }

    /// Measured TCP.
    pub(crate) fn tool(&self) -> Isometry3<f64> {
        pose(&self.state.arms[0].tcp)
    }

    /// Distance of the measured TCP from the goal (m).
    pub(crate) fn error(&self) -> f64 {
        let goal = pose(&self.decision.goals[0].target);
        (self.tool().translation.vector - goal.translation.vector).norm()
    }

    pub(crate) fn speed(&self) -> f64 {
        let speeds = self.command.joint_velocities.iter();
        speeds.fold(0.0, |worst, v| v.abs().max(worst))
    }

    /// One cycle; the task decides every tenth tick while it is alive.
    pub(crate) fn tick(&mut self, task_alive: bool) {
        if task_alive && self.state.header.tick.is_multiple_of(10) {
            self.decision.header = Header::caused_by::<Decision>(self.state.header.tick);
        }
        let before = self.command;
        self.cycle.update(
            &self.state,
            Some(&self.decision),
            LIMIT,
            &mut self.command,
            &mut self.status,
        );
        if before.joint_count != 0 {
            self.count_violations(&before);
        }
        let arm = &mut self.state.arms[0];
        arm.joint_positions = self.command.joint_positions;
        arm.joint_velocities = self.command.joint_velocities;
        arm.setpoint_positions = self.command.joint_positions;
        arm.setpoint_velocities = self.command.joint_velocities;
        arm.setpoint_accelerations = self.command.joint_accelerations;
        self.state.header.tick += 1;
        self.measure();
    }

    /// Ticks with a task that is alive.
    pub(crate) fn run(&mut self, ticks: usize) {
        for _ in 0..ticks {
            self.tick(true);
        }
    }

    /// As physics counts them.
    fn count_violations(&mut self, before: &ArmCommand) {
        let limits = self.cell.arms[0].robot.limits();
        let over = 1.0 + 1.0e-6;
        for joint in 0..6 {
            let now = &self.command;
            let velocity = now.joint_velocities[joint];
            let quotient = (velocity - before.joint_velocities[joint]) / 1.0e-3;
            let jerk = (quotient - before.joint_accelerations[joint]) / 1.0e-3;
            let position = now.joint_positions[joint];
            let kept = velocity.abs() <= limits.velocity[joint] * over
                && quotient.abs() <= limits.acceleration[joint] * over
                && jerk.abs() <= limits.jerk[joint] * over
                && (limits.lower[joint]..=limits.upper[joint]).contains(&position);
            // Written so that NaN counts, too.
            self.violations += usize::from(!kept);
        }
    }

    fn measure(&mut self) {
        let robot = &self.cell.arms[0].robot;
        let joints = robot.with_arm_positions(&self.state.arms[0].joint_positions[..6]);
        let tcp = robot.frame_pose(robot.tcp_frame, &joints).expect("a frame");
        self.state.arms[0].tcp = wire(&tcp);
    }
}

pub(crate) fn wire(pose: &Isometry3<f64>) -> Pose {
    let r = pose.rotation;
    Pose {
        position: pose.translation.vector.into(),
        orientation_wxyz: [r.w, r.i, r.j, r.k],
    }
}

pub(crate) fn pose(pose: &Pose) -> Isometry3<f64> {
    let [w, i, j, k] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Vector3::from(pose.position).into(), rotation)
}
