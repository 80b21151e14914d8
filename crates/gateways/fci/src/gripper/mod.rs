//! The interface of the hand (libfranka-common, `research_interface/gripper/types.h`,
//! version 3): requests in, a command of the fingers and states out.

mod messages;

use serde::{Deserialize, Serialize};

use crate::bytes::Writer;

pub use messages::{
    GRIPPER_HEADER_BYTES, GRIPPER_REQUEST_BYTES, GRIPPER_STATE_BYTES, GRIPPER_VERSION,
    GripperFramed, GripperReply, GripperRequest, decode_gripper,
};

/// Cycles without motion after which the fingers count as stopped.
const STILL_CYCLES: u32 = 60;
/// Velocity below which the fingers do not move (m/s).
const STILL_M_S: f64 = 1.0e-3;
/// Distance at which a width is reached (m).
const REACHED_M: f64 = 1.0e-3;
/// Cycles after which a motion that has not reached its width has failed.
const PATIENCE_CYCLES: u32 = 300;
/// Speed while the stops are sought (m/s).
const HOMING_M_S: f64 = 0.05;

const SUCCESS: u16 = 0;
const FAILED: u16 = 1;
const UNSUCCESSFUL: u16 = 2;
const ABORTED: u16 = 3;

/// The fingers as measured.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fingers {
    /// Distance between the fingers (m).
    pub width: f64,
    /// Its rate (m/s).
    pub velocity: f64,
    /// Force on what they hold (N).
    pub force: f64,
}

/// What the fingers do.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
enum Action {
    Homing,
    Move,
    Grasp { least: f64, most: f64 },
}

/// An action in progress.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Busy {
    action: Action,
    command: u16,
    id: u32,
    /// Width at the end (m).
    goal: f64,
    /// m/s.
    speed: f64,
    /// Cycles since the last motion of the fingers.
    still: u32,
}

/// The hand behind its interface.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Gripper {
    max_width: f64,
    default_force: f64,
    max_force: f64,
    /// Commanded width (m) and force (N).
    width: f64,
    force: f64,
    busy: Option<Busy>,
    is_grasped: bool,
    replies: [Option<GripperReply>; 4],
}

impl Gripper {
    /// A hand of this robot, open.
    pub fn new(hand: &cell_model::ParallelGripper) -> Self {
        Self {
            max_width: hand.max_width,
            default_force: hand.default_force,
            max_force: hand.max_force,
            width: hand.max_width,
            force: hand.default_force,
            busy: None,
            is_grasped: false,
            replies: [None; 4],
        }
    }

    /// Continues from the command in force: silence of a client moves no finger.
    pub fn begin(&mut self, width: f64) {
        self.width = width.clamp(0.0, self.max_width);
    }

    /// Continues from the memory of `other`, a hand of the same robot.
    pub fn resume(&mut self, other: &Self) {
        *self = Self {
            max_width: self.max_width,
            default_force: self.default_force,
            max_force: self.max_force,
            ..other.clone()
        };
    }

    /// Whether a request is being executed.
    pub fn is_busy(&self) -> bool {
        self.busy.is_some()
    }

    /// The next reply.
    pub fn take_reply(&mut self) -> Option<GripperReply> {
        self.replies.iter_mut().find_map(Option::take)
    }

    /// Starts a request. `Connect` is of the connection, and does nothing here.
    pub fn request(&mut self, framed: &GripperFramed, fingers: &Fingers) {
        let GripperFramed { command, id, .. } = *framed;
        let start = |action, goal, speed: f64| Busy {
            action,
            command,
            id,
            goal,
            speed,
            still: 0,
        };
        let wanted = match framed.request {
            GripperRequest::Connect { .. } => return,
            GripperRequest::Stop => {
                self.abort();
                if !self.is_grasped {
                    self.width = fingers.width;
                }
                return self.reply(command, id, SUCCESS);
            }
            GripperRequest::Homing => start(Action::Homing, self.max_width, HOMING_M_S),
            GripperRequest::Move { width, speed } => start(Action::Move, width, speed),
            GripperRequest::Grasp {
                width,
                inner,
                outer,
                speed,
                force,
            } => {
                if !(force > 0.0 && width.is_finite() && inner >= 0.0 && outer >= 0.0) {
                    return self.reply(command, id, FAILED);
                }
                self.force = force.min(self.max_force);
                let action = Action::Grasp {
                    least: width - inner,
                    most: width + outer,
                };
                // Closed, not the expected width: `inner` allows an object that is narrower.
                start(action, 0.0, speed)
            }
        };
        if !(wanted.speed > 0.0 && (0.0..=self.max_width).contains(&wanted.goal)) {
            return self.reply(command, id, FAILED);
        }
        self.abort();
        if !matches!(wanted.action, Action::Grasp { .. }) {
            self.force = self.default_force;
        }
        self.is_grasped = false;
        // From where the fingers are: after a grasp the command is inside of the object.
        self.width = fingers.width.clamp(0.0, self.max_width);
        self.busy = Some(wanted);
    }

    /// One cycle: the width (m) and the force (N) of the command.
    pub fn advance(&mut self, fingers: &Fingers) -> (f64, f64) {
        let Some(mut busy) = self.busy else {
            return (self.width, self.force);
        };
        let step = busy.speed * 1.0e-3;
        self.width += (busy.goal - self.width).clamp(-step, step);
        busy.still = if fingers.velocity.abs() < STILL_M_S {
            busy.still + 1
        } else {
            0
        };
        self.busy = Some(busy);
        if let Some(status) = self.ended(&busy, fingers) {
            self.busy = None;
            self.reply(busy.command, busy.id, status);
        }
        (self.width, self.force)
    }

    /// The status of an action that has ended.
    fn ended(&mut self, busy: &Busy, fingers: &Fingers) -> Option<u16> {
        let is_still = busy.still >= STILL_CYCLES;
        match busy.action {
            Action::Homing | Action::Move => {
                let is_there = self.width == busy.goal;
                let is_reached = (fingers.width - busy.goal).abs() < REACHED_M;
                match (
                    is_there && is_reached,
                    is_there && busy.still >= PATIENCE_CYCLES,
                ) {
                    (true, _) => Some(SUCCESS),
                    (_, true) => Some(FAILED),
                    _ => None,
                }
            }
            Action::Grasp { least, most } => {
                // At first the fingers do not move yet.
                let has_led = fingers.width - self.width > REACHED_M || self.width == busy.goal;
                if !(is_still && has_led) {
                    return None;
                }
                // The force rises after the fingers have stopped.
                let holds = fingers.force > 0.0;
                if !holds && busy.still < PATIENCE_CYCLES {
                    return None;
                }
                self.is_grasped = holds && (least..=most).contains(&fingers.width);
                // The fingers keep pressing.
                self.width = 0.0;
                Some(if self.is_grasped {
                    SUCCESS
                } else {
                    UNSUCCESSFUL
                })
            }
        }
    }

    /// Ends the action in progress; the fingers keep their command.
    pub fn abort(&mut self) {
        if let Some(busy) = self.busy.take() {
            self.reply(busy.command, busy.id, ABORTED);
        }
    }

    /// The connection of the client has ended. The fingers keep their command.
    pub fn disconnect(&mut self) {
        self.abort();
        self.replies = [None; 4];
    }

    fn reply(&mut self, command: u16, id: u32, status: u16) {
        let free = self.replies.iter_mut().find(|slot| slot.is_none());
        if let Some(slot) = free {
            *slot = Some(GripperReply {
                command,
                id,
                status,
            });
        }
    }

    /// Writes the state numbered `message_id`.
    pub fn write_state(
        &self,
        message_id: u32,
        fingers: &Fingers,
        out: &mut [u8; GRIPPER_STATE_BYTES],
    ) {
        /// Temperature of a hand in use (°C).
        const TEMPERATURE: u16 = 30;
        let mut to = Writer::new(out);
        to.bytes(&message_id.to_le_bytes());
        to.bytes(&fingers.width.to_le_bytes());
        to.bytes(&self.max_width.to_le_bytes());
        // Until the held object has left.
        let is_grasped = self.is_grasped && fingers.force > 0.0;
        to.bytes(&[u8::from(is_grasped)]);
        to.bytes(&TEMPERATURE.to_le_bytes());
    }
}
