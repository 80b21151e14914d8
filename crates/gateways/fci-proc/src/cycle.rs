//! The interface without sockets and ports: inputs of a client and a state in, a command out.
//! The process runs it once per state, and `replay --verify` runs it again on a recording.

use bincode::Options;
use cell_model::{Cell, Robot};
use fci::{
    Arm, ArmMemory, Error, Gripper, GripperReply, NotSevenJoints, Reflex, Reply, RobotCommand,
};
use ipc_types::arm::ClientState;
use ipc_types::client::ClientEvent;
use ipc_types::topic::TopicId;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Input, Text, WorldState};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::messages::{self, Progress};

/// Gravity in the world frame (m/s²).
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);
/// Grip force from which a hand holds something in the first cycle (N).
const HOLDING_FORCE_N: f64 = 1.0;
/// Version of the checkpoint; another one is refused.
const VERSION: u32 = 2;

/// Why an arm has no such interface.
#[derive(Debug, thiserror::Error)]
#[error("arm {arm}: {reason}; robot `fr3` is such an arm")]
pub struct RobotError {
    /// Name of the arm.
    arm: String,
    reason: NotSevenJoints,
}

/// Why a checkpoint was refused.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// Written by another version.
    #[error(
        "the checkpoint of the control interface has layout version {0}, this build reads {VERSION}; use the build that wrote it"
    )]
    Version(u32),
    /// It does not fit.
    #[error("the checkpoint of the control interface does not fit {0} bytes")]
    TooLong(usize),
    /// Not a checkpoint, or cut.
    #[error("the checkpoint of the control interface is damaged: {0}")]
    Damaged(#[from] bincode::Error),
}

/// The interface of one arm.
pub struct Cycle {
    arm: u8,
    robot: Arm,
    gripper: Option<Gripper>,
    memory: Memory,
}

/// Its memory, without that of arm and hand.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Memory {
    /// Generation of physics and tick that were answered last.
    answered: Option<(u32, u64)>,
    /// Generation of physics and count of scene resets in the last cycle.
    began_with: Option<(u32, u32)>,
    /// Newest recorded input of a client: generation of this process, and number.
    input: Option<(u32, u64)>,
    cycles: u64,
    missed_cycles: u64,
    is_connected: bool,
    ended: u32,
    motions: u32,
    failures: u32,
    /// Of the last motion that failed.
    failure: Option<Failure>,
    /// The drives ended a motion, which was not reported yet.
    #[serde(skip)]
    was_held: bool,
}

/// Why a motion did not end as its client wanted.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Failure {
    /// A rule of the robot.
    Reflex(Error),
    /// The drives did not follow commands.
    Held,
    /// The connection of its client ended.
    ClientEnded,
}

impl Failure {
    fn name(self) -> &'static str {
        match self {
            Self::Reflex(error) => error.name(),
            Self::Held => "drives_held",
            Self::ClientEnded => "client_ended_in_motion",
        }
    }
}

impl Cycle {
    /// The interface of the arm with number `arm` of `cell`, at rest at home.
    ///
    /// # Errors
    ///
    /// Where the arm has not seven revolute joints, or is not in the cell.
    pub fn new(cell: &Cell, arm: u8) -> Result<Self, RobotError> {
        let wrong = |arm: &str, reason| RobotError {
            arm: arm.to_owned(),
            reason,
        };
        let spec = cell.arms.get(usize::from(arm));
        let spec = spec.ok_or_else(|| wrong("without a place in the cell", NotSevenJoints))?;
        let robot: &Robot = &spec.robot;
        let gravity = spec.base.rotation.inverse() * GRAVITY;
        let interface = Arm::new(robot, &spec.home, gravity);
        Ok(Self {
            arm,
            robot: interface.map_err(|reason| wrong(&spec.name, reason))?,
            gripper: robot.gripper.as_ref().map(Gripper::new),
            memory: Memory::default(),
        })
    }

    /// The arm.
    pub fn robot(&self) -> &Arm {
        &self.robot
    }

    /// The hand; `None` where the robot has none.
    pub fn gripper(&self) -> Option<&Gripper> {
        self.gripper.as_ref()
    }

    /// Generation of physics and tick of the last cycle.
    pub fn answered(&self) -> Option<(u32, u64)> {
        self.memory.answered
    }

    /// Cycles of physics without one of this interface.
    pub fn missed_cycles(&self) -> u64 {
        self.memory.missed_cycles
    }

    /// Generation and number of the newest recorded input of a client.
    pub fn input(&self) -> Option<(u32, u64)> {
        self.memory.input
    }

    /// Whether no cycle has run since physics was replaced or the scene was reset. The next motion
    /// would otherwise find that out in its first cycle, and end.
    pub fn is_new_scene(&self, state: &WorldState) -> bool {
        self.memory.began_with != Some(scene(state))
    }

    /// The present state was sent again `count` times.
    pub fn repeat(&mut self, count: u32) {
        self.robot.repeat(count);
    }

    /// Takes an input of the client; `state` is the newest one.
    pub fn take(&mut self, input: &ClientInput, state: Option<&WorldState>) {
        let header = &input.header;
        // Without a number it was not published: a replay lacks it, so no command may name it.
        if header.seq > 0 {
            self.memory.input = Some((header.generation, header.seq));
        }
        match ClientEvent::from_code(input.event) {
            Some(ClientEvent::Connected) => self.memory.is_connected = true,
            Some(ClientEvent::Request) => {
                if let Ok(Some(framed)) = fci::decode(input.bytes()) {
                    self.robot.request(&framed);
                }
            }
            Some(ClientEvent::Command) => {
                if let Some(command) = RobotCommand::decode(input.bytes()) {
                    self.robot.datagram(&command, input.is_awaited != 0);
                }
            }
            Some(ClientEvent::Ended) => {
                if self.robot.is_moving() {
                    self.fail(Failure::ClientEnded);
                }
                self.robot.disconnect();
                self.memory.is_connected = false;
                self.memory.ended = self.memory.ended.wrapping_add(1);
            }
            Some(ClientEvent::HandRequest) => self.hand_request(input.bytes(), state),
            Some(ClientEvent::HandEnded) => {
                if let Some(gripper) = &mut self.gripper {
                    gripper.disconnect();
                }
            }
            Some(ClientEvent::None) | None => {}
        }
    }

    fn hand_request(&mut self, bytes: &[u8], state: Option<&WorldState>) {
        let arm = state.and_then(|state| state.arms().get(usize::from(self.arm)));
        let fingers = arm.map(messages::fingers).unwrap_or_default();
        if let (Some(gripper), Ok(Some(framed))) = (&mut self.gripper, fci::decode_gripper(bytes)) {
            gripper.request(&framed, &fingers);
        }
    }

    /// One cycle of the robot; `false`, without a command, where the state has no such arm.
    pub fn update(
        &mut self,
        state: &WorldState,
        command: &mut ArmCommand,
        status: &mut ArmStatus,
    ) -> bool {
        let Some(arm) = state.arms().get(usize::from(self.arm)) else {
            return false;
        };
        let is_new = self.count(state);
        let measured = messages::measured(arm, is_new);
        let fingers = messages::fingers(arm);
        if measured.is_held && self.robot.is_moving() {
            self.fail(Failure::Held);
            self.memory.was_held = true;
        }
        let setpoint = self.robot.advance(&measured);
        let (width, force) = self.gripper.as_mut().map_or((0.0, 0.0), |gripper| {
            if is_new {
                // A hand that holds something keeps its grip: an open width would drop it.
                let holds = fingers.force > HOLDING_FORCE_N;
                gripper.begin(if holds { 0.0 } else { fingers.width });
            }
            gripper.advance(&fingers)
        });
        let inputs = (state, self.newest_input());
        messages::command(inputs, (self.arm, width, force), &setpoint, command);
        messages::status(inputs, arm, command, &self.progress(), status);
        true
    }

    /// Counts a cycle; whether the scene is new.
    fn count(&mut self, state: &WorldState) -> bool {
        let memory = &mut self.memory;
        let (generation, tick) = (state.header.generation, state.header.tick);
        let is_new = memory.began_with.replace(scene(state)) != Some(scene(state));
        let last = memory
            .answered
            .filter(|(answered, _)| *answered == generation);
        let ticks = last.map_or(1, |(_, last)| tick.saturating_sub(last));
        memory.missed_cycles += ticks.saturating_sub(1);
        memory.cycles += 1;
        memory.answered = Some((generation, tick));
        is_new
    }

    fn newest_input(&self) -> Option<Input> {
        let (generation, seq) = self.memory.input?;
        Some(Input {
            topic: TopicId::ClientTap(self.arm).code(),
            generation,
            seq,
            age_ticks: 0,
        })
    }

    fn progress(&self) -> Progress {
        let memory = &self.memory;
        Progress {
            is_moving: self.robot.is_moving(),
            cycles: memory.cycles,
            missed_cycles: memory.missed_cycles,
            client: ClientState {
                connected: u32::from(memory.is_connected),
                ended: memory.ended,
                motions: memory.motions,
                failures: memory.failures,
                failure: Text::new(memory.failure.map_or("", Failure::name)),
            },
        }
    }

    /// The next reply to a request.
    pub fn take_reply(&mut self) -> Option<Reply> {
        let reply = self.robot.take_reply()?;
        let succeeded = u32::from(reply.is_success_of_motion());
        self.memory.motions = self.memory.motions.wrapping_add(succeeded);
        Some(reply)
    }

    /// The next reply of the hand.
    pub fn take_hand_reply(&mut self) -> Option<GripperReply> {
        self.gripper.as_mut()?.take_reply()
    }

    /// The reflex of the last cycle, once.
    pub fn take_reflex(&mut self) -> Option<Reflex> {
        let reflex = self.robot.take_reflex()?;
        self.fail(Failure::Reflex(reflex.broken.error));
        Some(reflex)
    }

    /// Whether the drives ended a motion in the last cycle, once.
    pub fn take_held(&mut self) -> bool {
        std::mem::take(&mut self.memory.was_held)
    }

    fn fail(&mut self, failure: Failure) {
        self.memory.failures = self.memory.failures.wrapping_add(1);
        self.memory.failure = Some(failure);
    }

    /// Takes replies and reflex without a client.
    pub fn discard_replies(&mut self) {
        while self.take_reply().is_some() || self.take_hand_reply().is_some() {}
        let _reflex = self.take_reflex();
        self.memory.was_held = false;
    }

    /// Writes a checkpoint; its length. Allocates nothing.
    ///
    /// # Errors
    ///
    /// Where it does not fit.
    pub fn save(&self, bytes: &mut [u8]) -> Result<usize, CheckpointError> {
        let length = bytes.len();
        let mut rest = bytes;
        let whole = (VERSION, &self.memory, self.robot.memory(), &self.gripper);
        let saved = bincode::serialize_into(&mut rest, &whole);
        saved.map_err(|_| CheckpointError::TooLong(length))?;
        Ok(length - rest.len())
    }

    /// Continues from a checkpoint of the same arm.
    ///
    /// # Errors
    ///
    /// Where it is of another version, or damaged; the cycle is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), CheckpointError> {
        // Before the rest, whose fields another version may not have.
        let version: u32 = bincode::deserialize(bytes)?;
        if version != VERSION {
            return Err(CheckpointError::Version(version));
        }
        // Unlike `bincode::deserialize` these options refuse bytes behind the last field.
        let options = bincode::DefaultOptions::new().with_fixint_encoding();
        let whole: (u32, Memory, ArmMemory, Option<Gripper>) = options.deserialize(bytes)?;
        let (_, memory, arm, hand) = whole;
        self.memory = memory;
        self.robot.resume(arm);
        if let (Some(gripper), Some(hand)) = (&mut self.gripper, hand) {
            gripper.resume(&hand);
        }
        Ok(())
    }
}

/// Generation of physics and count of scene resets.
fn scene(state: &WorldState) -> (u32, u32) {
    (state.header.generation, state.panel.scene_reset)
}
