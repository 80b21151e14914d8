//! The robot as its interface shows it: requests and commands in, setpoints, states and
//! replies out. Time is a count of cycles of 1 ms.

mod cycle;
mod requests;

use cell_model::ramp::RampState;
use cell_model::{Dynamics, Robot, SelfDistance};
use nalgebra::{Isometry3, Vector3};
use rmp::JointLimits;
use serde::{Deserialize, Serialize};

use crate::JOINTS;
use crate::datagram::RobotCommand;
use crate::error::Errors;
use crate::hand::{self, Hand};
use crate::kinematics::{Joints, Kinematics};
use crate::limits::{self, JointLimit};
use crate::motion::{Broken, Generator, Tool};
use crate::request::Reply;
use crate::state::{STATE_BYTES, StateValues, columns};

/// Answers in a row that may be late or missing before the robot stops.
// The number of the robot (`system_requirements.rst` of the maker).
pub const LOST_ANSWERS: u32 = 20;
/// Cycles over which the success rate of commands is counted.
// The number of `control_command_success_rate` in libfranka.
const RATE_CYCLES: u32 = 100;

/// The joints as measured in a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// rad.
    pub positions: [f64; JOINTS],
    /// rad/s.
    pub velocities: [f64; JOINTS],
    /// Efforts of the drives, with gravity (N·m).
    pub torques: [f64; JOINTS],
    /// The setpoint in force.
    pub setpoint: [RampState; JOINTS],
    /// The drives do not follow commands: they hold, or started again.
    pub is_held: bool,
}

/// The setpoint of a cycle.
#[derive(Clone, Copy, Debug)]
pub struct Setpoint {
    /// Position, velocity and acceleration of each joint.
    pub joints: [RampState; JOINTS],
    /// Efforts: with a torque motion those of the drives, else a feed-forward; with gravity
    /// (N·m).
    pub efforts: [f64; JOINTS],
    /// Whether the drives give these efforts alone.
    pub by_torque: bool,
}

/// How an answer to a state was late.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LateAnswer {
    /// The state.
    pub message_id: u64,
    /// Cycles from the state to its answer; `None` where none came.
    pub after_cycles: Option<u32>,
}

/// A motion that a rule of the robot ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflex {
    /// The value and its limit.
    pub broken: Broken,
    /// Cycle of the motion, from 1.
    pub cycle: u64,
    /// With an error of communication the answers of its last cycles, oldest first.
    pub late: [Option<LateAnswer>; LOST_ANSWERS as usize],
}

/// A motion of a client.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Motion {
    /// Number of its request.
    id: u32,
    controller: u8,
    generator: Generator,
    /// Number of the generator as requested.
    generator_number: u8,
    /// The client has answered a state of it.
    is_running: bool,
    cycles: u64,
    /// Answers missing in a row.
    lost: u32,
}

impl Motion {
    fn by_torque(&self) -> bool {
        self.controller == 2
    }
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Mode {
    Idle,
    Move(Motion),
    Reflex,
}

/// Why a robot has no such interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotSevenJoints;

impl std::fmt::Display for NotSevenJoints {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the Franka control interface is that of an arm with seven revolute joints")
    }
}

/// What an arm remembers from one cycle to the next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ArmMemory {
    nominal_to_end: Isometry3<f64>,
    stiffness_frame: [f64; 16],
    load: (f64, [f64; 3], [f64; 9]),
    mode: Mode,
    errors: Errors,
    reflex_reason: Errors,
    /// A request that waits for the arm to be at rest.
    waiting: Option<requests::Waiting>,
    /// Number of the state that was sent last.
    message_id: u64,
    /// Whether the client answered, for the last cycles, newest in the lowest bit.
    answered: u128,
    /// Number of the newest state that was answered, or that was sent before the motion.
    answered_id: u64,
    answer: Option<RobotCommand>,
    late: [Option<LateAnswer>; LOST_ANSWERS as usize],
    joints: [RampState; JOINTS],
    /// After the first command of a motion: the joints there, at rest.
    start: Option<[RampState; JOINTS]>,
    tool: Tool,
    torques: [f64; JOINTS],
    external: [f64; JOINTS],
    replies: [Option<Reply>; 4],
    /// Taken in the cycle in which it occurs.
    #[serde(skip)]
    reflex: Option<Reflex>,
}

/// The robot behind its interface.
pub struct Arm {
    limits: [JointLimit; JOINTS],
    ramp_limits: JointLimits,
    kinematics: Kinematics,
    dynamics: Dynamics,
    robot: Robot,
    self_distance: SelfDistance,
    /// Positions of all joints of the robot, those of the arm as commanded.
    all_positions: Vec<f64>,
    gravity: Vector3<f64>,
    nominal: Isometry3<f64>,
    hand: Hand,
    memory: ArmMemory,
}

impl Arm {
    /// The interface of `robot`, at rest at `home` (rad), in a base frame with this gravity
    /// (m/s²).
    ///
    /// # Errors
    ///
    /// Where the robot has not seven revolute joints.
    pub fn new(robot: &Robot, home: &[f64], gravity: Vector3<f64>) -> Result<Self, NotSevenJoints> {
        let limits = limits::of(robot).ok_or(NotSevenJoints)?;
        let home: [f64; JOINTS] = home.try_into().map_err(|_| NotSevenJoints)?;
        let kinematics = Kinematics::new(robot);
        let nominal = hand::nominal(robot);
        let joints = home.map(|position| RampState {
            position,
            ..RampState::default()
        });
        let pose = kinematics.flange(&Joints::from(home)) * nominal;
        let memory = ArmMemory {
            nominal_to_end: Isometry3::identity(),
            stiffness_frame: columns(&Isometry3::identity()),
            load: (0.0, [0.0; 3], [0.0; 9]),
            mode: Mode::Idle,
            errors: Errors::default(),
            reflex_reason: Errors::default(),
            waiting: None,
            message_id: 0,
            answered: 0,
            answered_id: 0,
            answer: None,
            late: [None; LOST_ANSWERS as usize],
            joints,
            start: None,
            tool: Tool::at(pose),
            torques: [0.0; JOINTS],
            external: [0.0; JOINTS],
            replies: [None; 4],
            reflex: None,
        };
        Ok(Self {
            limits,
            ramp_limits: robot.limits(),
            kinematics,
            dynamics: Dynamics::new(robot),
            self_distance: SelfDistance::new(robot),
            all_positions: robot.with_arm_positions(&home),
            robot: robot.clone(),
            gravity,
            nominal,
            hand: Hand::of(robot),
            memory,
        })
    }

    /// Its memory: an arm of the same robot that resumes from it gives the same commands.
    pub fn memory(&self) -> &ArmMemory {
        &self.memory
    }

    /// Continues from `memory`.
    pub fn resume(&mut self, memory: ArmMemory) {
        self.memory = memory;
    }

    /// A command of the client. In real time one that answers an earlier state than the last is
    /// late, and only counted. In lockstep nothing is late: commands are taken in their order,
    /// one in each cycle, so that a run does not depend on the machine.
    pub fn datagram(&mut self, command: &RobotCommand, in_lockstep: bool) {
        // The first answer of a motion may be to any of its states: until then none is lost.
        let is_first = self.is_moving() && !self.is_running();
        let is_in_order = command.message_id > self.memory.answered_id;
        if command.message_id == self.memory.message_id
            || (is_in_order && (is_first || in_lockstep))
        {
            self.memory.answered_id = command.message_id;
            self.memory.answer = Some(*command);
            return;
        }
        let behind = self.memory.message_id.saturating_sub(command.message_id);
        let late = self.memory.late.iter_mut().flatten();
        for late in late.filter(|late| late.message_id == command.message_id) {
            late.after_cycles = u32::try_from(behind).ok();
        }
    }

    /// Whether the state sent last was answered.
    pub fn is_answered(&self) -> bool {
        self.memory.answer.is_some()
    }

    /// Whether a motion waits for answers of the client.
    pub fn is_moving(&self) -> bool {
        matches!(self.memory.mode, Mode::Move(_))
    }

    /// Whether the client has answered a state of the present motion.
    pub fn is_running(&self) -> bool {
        matches!(self.memory.mode, Mode::Move(motion) if motion.is_running)
    }

    /// Whether the commanded motion has ended.
    pub fn is_at_rest(&self) -> bool {
        self.memory.joints.iter().all(RampState::is_at_rest)
    }

    /// Number of the state that was sent last.
    pub fn message_id(&self) -> u64 {
        self.memory.message_id
    }

    /// The next reply to a request.
    pub fn take_reply(&mut self) -> Option<Reply> {
        self.memory.replies.iter_mut().find_map(Option::take)
    }

    /// The reflex of the last cycle, once.
    pub fn take_reflex(&mut self) -> Option<Reflex> {
        self.memory.reflex.take()
    }

    fn reply(&mut self, reply: Reply) {
        // Always found: the caller takes the replies after each request and each cycle, and neither
        // gives more than two.
        let free = self.memory.replies.iter_mut().find(|slot| slot.is_none());
        if let Some(slot) = free {
            *slot = Some(reply);
        }
    }

    fn end_effector(&self) -> Isometry3<f64> {
        self.nominal * self.memory.nominal_to_end
    }

    /// Writes the next state, as of `measured`.
    pub fn write_state(&self, measured: &Measured, out: &mut [u8; STATE_BYTES]) {
        let end_effector = self.end_effector();
        // In a state 0 is the idle generator, so each one has its number of the request plus 1;
        // controller 3 means that none runs.
        let (generator_mode, controller_mode, robot_mode) = match self.memory.mode {
            Mode::Idle => (0, 3, 1),
            Mode::Move(motion) => (motion.generator_number + 1, motion.controller, 2),
            Mode::Reflex => (0, 3, 4),
        };
        let successes = (self.memory.answered & ((1 << RATE_CYCLES) - 1)).count_ones();
        StateValues {
            message_id: self.memory.message_id,
            measured_pose: self.kinematics.flange(&measured.positions.into()) * end_effector,
            commanded: &self.memory.tool,
            end_effector,
            nominal: self.nominal,
            nominal_to_end: self.memory.nominal_to_end,
            stiffness_frame: self.memory.stiffness_frame,
            hand: &self.hand,
            load: self.memory.load,
            positions: measured.positions,
            velocities: measured.velocities,
            torques: measured.torques,
            commanded_torques: self.memory.torques,
            commanded_positions: self.memory.joints.map(|joint| joint.position),
            commanded_velocities: self.memory.joints.map(|joint| joint.velocity),
            commanded_accelerations: self.memory.joints.map(|joint| joint.acceleration),
            external_torques: self.memory.external,
            external_wrench: nalgebra::Vector6::zeros(),
            generator_mode,
            controller_mode,
            errors: self.memory.errors,
            reflex_reason: self.memory.reflex_reason,
            robot_mode,
            // The robot reports 0 while no motion runs (`robot_state.h`).
            success_rate: if self.is_running() {
                f64::from(successes) / f64::from(RATE_CYCLES)
            } else {
                0.0
            },
        }
        .write(out);
    }
}
