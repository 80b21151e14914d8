//! A scripted controller for the tests: joint trajectories with feed-forward.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "test support, and not every test uses everything"
)]

use cell_model::{Cell, Data, Dynamics, Robot};
use ipc_types::{ArmCommand, GripperCommand, Header, Wire, WorldState};
use nalgebra::{Isometry3, SMatrix, SVector, Translation3, UnitQuaternion, Vector3};
use physics_proc::world::{StepInput, World};

pub const HOME: [f64; 7] = [0.012, -0.5686, 0.0, -2.8102, 0.0, 3.0366, 0.741];

/// One arm, one world, one commanded posture.
pub struct Rig {
    /// The arm that is commanded; every other one receives no command.
    pub arm: usize,
    pub cell: Cell,
    pub world: World,
    pub joints: [f64; 7],
    pub width: f64,
    pub force: f64,
    dynamics: Dynamics,
    seq: u64,
}

impl Rig {
    pub fn new(seed: u64) -> Self {
        Self::with(Cell::load(&Data::checkout(), "franka-stack", seed, None).unwrap())
    }

    pub fn with(cell: Cell) -> Self {
        Self::of_arm(cell, 0)
    }

    pub fn of_arm(cell: Cell, arm: usize) -> Self {
        let world = World::new(&cell).unwrap();
        let dynamics = Dynamics::new(&cell.arms[arm].robot);
        Self {
            arm,
            cell,
            world,
            joints: HOME,
            width: 0.08,
            force: 20.0,
            dynamics,
            seq: 0,
        }
    }

    pub fn robot(&self) -> &Robot {
        &self.cell.arms[self.arm].robot
    }

    pub fn command(&mut self, q: &[f64; 7], qd: &[f64; 7], qdd: &[f64; 7]) -> ArmCommand {
        self.seq += 1;
        let mut command = ArmCommand::zeroed();
        command.header = Header::caused_by::<ArmCommand>(self.world.tick());
        command.header.generation = 1;
        command.header.seq = self.seq;
        command.arm = u32::try_from(self.arm).unwrap();
        command.joint_count = 7;
        command.joint_positions[..7].copy_from_slice(q);
        command.joint_velocities[..7].copy_from_slice(qd);
        command.joint_accelerations[..7].copy_from_slice(qdd);
        let gravity = Vector3::new(0.0, 0.0, -9.81);
        command.joint_efforts[..7]
            .copy_from_slice(self.dynamics.inverse_dynamics(q, qd, qdd, &gravity));
        command.gripper = GripperCommand {
            width: self.width,
            force: self.force,
            suction: 0,
            reserved: 0,
        };
        command
    }

    pub fn apply(&mut self, command: &ArmCommand) {
        let mut commands = [None; ipc_types::MAX_ARMS];
        commands[self.arm] = Some(command);
        self.world.step(&StepInput {
            commands,
            decision: None,
        });
    }

    /// Stays where it is commanded.
    pub fn stay(&mut self, ticks: u64) {
        for _ in 0..ticks {
            let command = self.command(&self.joints.clone(), &[0.0; 7], &[0.0; 7]);
            self.apply(&command);
        }
    }

    /// Moves the joints to `goal` in `seconds`: a polynomial of seventh degree,
    /// so that velocity, acceleration and jerk are zero at the start and at the end.
    pub fn travel(&mut self, goal: [f64; 7], seconds: f64) {
        let start = self.joints;
        let ticks = (seconds * 1e3) as u64;
        for tick in 1..=ticks {
            let s = tick as f64 / ticks as f64;
            let p = s.powi(4) * (35.0 - 84.0 * s + 70.0 * s * s - 20.0 * s * s * s);
            let v = 140.0 * s.powi(3) * (1.0 - s).powi(3) / seconds;
            let a = 420.0 * s * s * (1.0 - s).powi(2) * (1.0 - 2.0 * s) / (seconds * seconds);
            let scaled = |k: f64| -> [f64; 7] { std::array::from_fn(|j| k * (goal[j] - start[j])) };
            let q = std::array::from_fn(|j| start[j] + p * (goal[j] - start[j]));
            let command = self.command(&q, &scaled(v), &scaled(a));
            self.apply(&command);
        }
        self.joints = goal;
    }

    /// Joints that bring the TCP to `position` (world), pointing straight down,
    /// turned by `yaw`.
    pub fn solve(&self, position: [f64; 3], yaw: f64) -> [f64; 7] {
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
        let target =
            Isometry3::from_parts(Translation3::from(Vector3::from(position)), turn * down);
        let target = self.cell.arms[self.arm].base.inverse() * target;
        let robot = self.robot();
        let pose = |q: &[f64; 7]| {
            robot
                .frame_pose(robot.tcp_frame, &robot.with_arm_positions(q))
                .unwrap()
        };
        let error = |q: &[f64; 7]| -> SVector<f64, 6> {
            let at = pose(q);
            let turn = (target.rotation * at.rotation.inverse()).scaled_axis();
            let way = target.translation.vector - at.translation.vector;
            SVector::from_column_slice(&[way.x, way.y, way.z, turn.x, turn.y, turn.z])
        };
        let mut q = self.joints;
        for _ in 0..200 {
            let now = error(&q);
            if now.norm() < 1e-12 {
                break;
            }
            let mut jacobian = SMatrix::<f64, 6, 7>::zeros();
            for j in 0..7 {
                let mut moved = q;
                moved[j] += 1e-6;
                jacobian.set_column(j, &((now - error(&moved)) / 1e-6));
            }
            let square = jacobian * jacobian.transpose() + SMatrix::<f64, 6, 6>::identity() * 1e-8;
            let step = jacobian.transpose() * square.lu().solve(&now).unwrap();
            for j in 0..7 {
                q[j] += step[j].clamp(-0.2, 0.2);
            }
        }
        assert!(error(&q).norm() < 1e-6, "no posture for {position:?}");
        q
    }

    pub fn state(&self) -> WorldState {
        let mut state = WorldState::zeroed();
        self.world.write_state(&mut state);
        state
    }

    pub fn object(&self, index: usize) -> Isometry3<f64> {
        isometry(&self.state().objects[index].pose)
    }

    /// Pose of an object as the hand sees it.
    pub fn object_in_hand(&self, index: usize) -> Isometry3<f64> {
        let state = self.state();
        isometry(&state.arms[self.arm].tcp).inverse() * isometry(&state.objects[index].pose)
    }

    /// Opens above an object, goes down, closes, lifts by `height`.
    pub fn pick(&mut self, object: usize, height: f64) {
        self.pick_turned(object, height, 0.0);
    }

    /// As `pick`, the hand turned by `turn` from the object's own yaw.
    pub fn pick_turned(&mut self, object: usize, height: f64, turn: f64) {
        let pose = self.object(object);
        let (_, _, yaw) = pose.rotation.euler_angles();
        self.pick_at_turned(pose.translation.vector.into(), height, yaw + turn);
    }

    /// Opens above `place`, goes down, closes, lifts by `height`.
    pub fn pick_at(&mut self, place: [f64; 3], height: f64) {
        self.pick_at_turned(place, height, 0.0);
    }

    fn pick_at_turned(&mut self, [x, y, z]: [f64; 3], height: f64, yaw: f64) {
        self.width = 0.08;
        let above = self.solve([x, y, z + 0.1], yaw);
        self.travel(above, 2.0);
        let low = self.solve([x, y, z], yaw);
        self.travel(low, 1.0);
        self.width = 0.0;
        self.stay(500);
        let high = self.solve([x, y, z + height], yaw);
        self.travel(high, 1.5);
    }
}

pub fn isometry(pose: &ipc_types::Pose) -> Isometry3<f64> {
    let [w, x, y, z] = pose.orientation_wxyz;
    let rotation = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(Vector3::from(pose.position)), rotation)
}
