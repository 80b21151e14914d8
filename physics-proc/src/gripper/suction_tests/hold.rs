//! A cup, a block before it, and the commands that keep or move the arm.

use cell_model::{Cell, Data, Dynamics};
use ipc_types::{ArmCommand, GripperState, Header, Wire, WorldState};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::engine::convert;
use crate::world::{StepInput, World};

pub(super) const CELL: &str = r#"
description = "A cup and a block"
policies = ["x"]
default_policy = "x"
time_limit_s = 100.0
camera = { eye_m = [2.0, 2.0, 2.0], target_m = [0.0, 0.0, 0.0] }
task = { kind = "reach" }

[[arm]]
name = "ur10"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]

[[object]]
name = "block"
shape = { kind = "box", size_m = [0.1, 0.1, 0.1] }
mass_kg = 1.0
friction = 0.6
position_m = [0.0, 0.0, 0.0]
colour = [0.5, 0.5, 0.5]

[[fixture]]
name = "floor"
shape = { kind = "box", size_m = [4.0, 4.0, 0.1] }
position_m = [0.0, 0.0, -1.0]
friction = 0.6
obstacle = false
colour = [0.5, 0.5, 0.5]
"#;

/// A block right before the cup, which points down.
pub(super) struct Hold {
    pub(super) world: World,
    pub(super) cell: Cell,
    dynamics: Dynamics,
    pub(super) joints: Vec<f64>,
    /// Joint velocities (rad/s) and accelerations (rad/s²) that are commanded.
    pub(super) rates: Vec<f64>,
    pub(super) pushes: Vec<f64>,
    pub(super) seq: u64,
    pub(super) suction: u32,
}

impl Hold {
    /// `offset`: the block's centre from the cup across its axis (m); `gap`:
    /// from the cup to the surface (m); `tilt`: of the block (rad).
    pub(super) fn new(mass: f64, offset: [f64; 2], gap: f64, tilt: f64) -> Self {
        Self::with(CELL, |cell, cup| {
            let object = &mut cell.objects[0];
            object.mass = mass;
            let centre = cup + Vector3::new(offset[0], offset[1], -gap - 0.05);
            let tilt = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), tilt);
            object.pose = Isometry3::from_parts(Translation3::from(centre), tilt);
        })
    }

    /// A cell arranged for where its cup is.
    pub(super) fn with(text: &str, arrange: impl FnOnce(&mut Cell, Vector3<f64>)) -> Self {
        let data = Data::checkout();
        let mut cell = Cell::from_text(&data, "cup", "cup.toml", text, 1, None).unwrap();
        let arm = &mut cell.arms[0];
        let robot = &arm.robot;
        let quarter = std::f64::consts::FRAC_PI_2;
        arm.home = vec![-quarter, -quarter, -quarter, -quarter, quarter, 0.0];
        let all = robot.with_arm_positions(&arm.home);
        let tcp = robot.frame_pose(robot.tcp_frame, &all).unwrap();
        let axis = tcp.rotation * robot.suction.as_ref().unwrap().axis;
        assert!(axis.z < -0.999, "the cup points to {axis}");
        arrange(&mut cell, tcp.translation.vector);
        Self {
            world: World::new(&cell).unwrap(),
            dynamics: Dynamics::new(&cell.arms[0].robot),
            joints: cell.arms[0].home.clone(),
            rates: vec![0.0; 6],
            pushes: vec![0.0; 6],
            cell,
            seq: 0,
            suction: 1,
        }
    }

    fn command(&mut self) -> ArmCommand {
        self.seq += 1;
        let mut command = ArmCommand::zeroed();
        command.header = Header::caused_by::<ArmCommand>(self.world.tick());
        (command.header.generation, command.header.seq) = (1, self.seq);
        command.joint_count = 6;
        command.joint_positions[..6].copy_from_slice(&self.joints);
        command.joint_velocities[..6].copy_from_slice(&self.rates);
        command.joint_accelerations[..6].copy_from_slice(&self.pushes);
        let gravity = Vector3::new(0.0, 0.0, -9.81);
        let efforts =
            self.dynamics
                .inverse_dynamics(&self.joints, &self.rates, &self.pushes, &gravity);
        command.joint_efforts[..6].copy_from_slice(efforts);
        command.gripper.suction = self.suction;
        command
    }

    pub(super) fn tick(&mut self) {
        let command = self.command();
        let mut input = StepInput::default();
        input.commands[0] = Some(&command);
        self.world.step(&input);
    }

    pub(super) fn run(&mut self, ticks: u64) -> &mut Self {
        (0..ticks).for_each(|_| self.tick());
        self
    }

    /// Pulls with `force` (N, world) at a point of the block's top face `arm`
    /// away from the cup (m, world) while it runs one tick.
    pub(super) fn pull(&mut self, force: Vector3<f64>, arm: Vector3<f64>) {
        let (engine, arms) = self.world.engine_and_arms();
        let point = arms.tcp(engine, 0).unwrap().translation.vector + arm;
        let body = engine.object_mut(0).unwrap();
        body.reset_forces(true);
        body.reset_torques(true);
        body.add_force_at_point(convert::to_vector(&force), convert::to_vector(&point), true);
        self.tick();
    }

    pub(super) fn state(&self) -> WorldState {
        let mut state = WorldState::zeroed();
        self.world.write_state(&mut state);
        state
    }

    pub(super) fn gripper(&self) -> GripperState {
        self.state().arms[0].gripper
    }
}
