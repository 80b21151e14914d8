//! A cell with a belt, a supply of bins, a dispenser above a tray, and a task
//! that only sets outputs.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "test support, and not every test uses everything"
)]

use cell_model::{Cell, Data};
use ipc_types::decision::CellIo;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{DECISION_TICKS, Decision, Header, OperatorRequest, Wire, WorldState};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use physics_proc::world::{StepInput, World};

/// Objects of the cell: bins, then parts, then the tray.
pub const BINS: usize = 3;
pub const PARTS: usize = 12;
pub const TRAY: usize = BINS + PARTS;

const CELL: &str = r#"
description = "Everything a cell can have"
policies = ["x"]
default_policy = "x"
time_limit_s = 100.0
clear_below_m = -0.5
camera = { eye_m = [2.0, 2.0, 2.0], target_m = [0.0, 0.0, 0.0] }
task = { kind = "reach" }

[[arm]]
name = "ur10"
robot = "ur10"
base_position_m = [0.0, 0.0, 0.0]

[[object]]
name = "bin"
count = 3
pitch_m = [0.5, 0.0, 0.0]
shape = { kind = "bin", size_m = [0.3, 0.2, 0.147], wall_m = 0.004 }
mass_kg = 0.6
friction = 0.6
position_m = [3.0, 3.0, 0.2]
parked = true
sleeps = true
colour = [0.5, 0.5, 0.5]

[[object]]
name = "part"
count = 12
pitch_m = [0.1, 0.0, 0.0]
shape = { kind = "box", size_m = [0.024, 0.02, 0.016] }
other_shapes = [{ kind = "capsule", radius_m = 0.008, height_m = 0.02 }]
mass_kg = 0.05
friction = 0.6
angular_damping = 2.0
position_m = [3.0, 4.0, 0.2]
parked = true
sleeps = true
colour = [0.5, 0.5, 0.5]

[[object]]
name = "tray"
shape = { kind = "bin", size_m = [0.3, 0.2, 0.147], wall_m = 0.004 }
mass_kg = 0.6
friction = 0.6
position_m = [-0.8, 0.8, 0.0735]
sleeps = true
colour = [0.2, 0.7, 0.2]

[[fixture]]
name = "floor"
shape = { kind = "box", size_m = [4.0, 4.0, 0.1] }
position_m = [0.0, 0.0, -0.05]
friction = 0.6
obstacle = false
colour = [0.5, 0.5, 0.5]

[[fixture]]
name = "belt"
shape = { kind = "box", size_m = [0.5, 2.0, 0.2] }
position_m = [1.2, 0.6, 0.1]
friction = 0.8
obstacle = false
colour = [0.5, 0.5, 0.5]

[[fixture]]
name = "stop"
shape = { kind = "box", size_m = [0.5, 0.02, 0.3] }
position_m = [1.2, -0.41, 0.15]
friction = 0.2
obstacle = false
colour = [0.5, 0.5, 0.5]

[conveyor]
fixture = "belt"
velocity_m_s = [0.0, -0.3, 0.0]

[conveyor.supply]
objects = "bin"
position_m = [1.2, 1.4, 0.285]
spawn = { x_m = 0.05, y_m = 0.0, yaw_rad = 0.2 }
flipped_share = 0.5
max_waiting = 2
cool_down_s = 1.5

[dispenser]
objects = "part"
position_m = [-0.8, 0.8, 0.35]
spread_m = [0.05, 0.03]
layer_m = 0.05
per_drop = 3
interval_s = 0.2

[[sensor]]
name = "end"
position_m = [0.9, -0.3, 0.25]
direction = [1.0, 0.0, 0.0]
range_m = 0.6
"#;

/// The world and the outputs of its task.
pub struct Plc {
    world: World,
    pub io: CellIo,
    /// The task sends no decision.
    pub silent: bool,
    decision: Decision,
}

impl Plc {
    pub fn new(seed: u64) -> Self {
        Self::with(seed, |_| {})
    }

    /// The task has sent its first decision: its counters are zero.
    pub fn with(seed: u64, edit: impl FnOnce(&mut Cell)) -> Self {
        let data = Data::checkout();
        let mut cell = Cell::from_text(&data, "plc", "plc.toml", CELL, seed, None).unwrap();
        edit(&mut cell);
        let mut plc = Self {
            world: World::new(&cell).unwrap(),
            io: CellIo::zeroed(),
            silent: false,
            decision: Decision::zeroed(),
        };
        plc.decision.header.generation = 1;
        plc.run(1);
        plc
    }

    pub fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            let tick = self.world.tick();
            if tick.is_multiple_of(DECISION_TICKS) && !self.silent {
                let generation = self.decision.header.generation;
                self.decision.header = Header::caused_by::<Decision>(tick);
                self.decision.header.generation = generation;
                self.decision.io = self.io;
            }
            self.world.step(&StepInput {
                decision: Some(&self.decision),
                ..StepInput::default()
            });
        }
    }

    pub fn restore_from(&mut self, other: &Self) {
        self.world.restore(&other.world.snapshot()).unwrap();
        (self.io, self.decision) = (other.io, other.decision);
    }

    pub fn ask(&mut self, action: OperatorAction, count: u32) -> (ReplyCode, String) {
        let mut request = OperatorRequest::zeroed_at_identity();
        request.action = action.code();
        request.count = count;
        self.world.execute_request(action, &request)
    }

    pub fn drag(&mut self, object: usize, to: [f64; 3], seconds: f64) {
        let mut request = OperatorRequest::zeroed_at_identity();
        request.action = OperatorAction::Drag.code();
        request.object = object as u32;
        request.pose.position = to;
        request.seconds = seconds;
        let reply = self.world.execute_request(OperatorAction::Drag, &request);
        assert_eq!(reply.0, ReplyCode::Accepted, "{}", reply.1);
    }

    pub fn state(&self) -> Box<WorldState> {
        let mut state = Box::new(WorldState::zeroed());
        self.world.write_state(&mut state);
        state
    }

    pub fn pose(&self, object: usize) -> Isometry3<f64> {
        let pose = self.state().objects[object].pose;
        let [w, x, y, z] = pose.orientation_wxyz;
        Isometry3::from_parts(
            Translation3::from(Vector3::from(pose.position)),
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        )
    }

    pub fn position(&self, object: usize) -> Vector3<f64> {
        self.pose(object).translation.vector
    }

    pub fn lost(&self) -> usize {
        self.world.lost()
    }

    pub fn lost_words(&self) -> String {
        self.world.lost_words(0)
    }

    pub fn penetration(&self) -> f64 {
        self.world.penetration()
    }
}
