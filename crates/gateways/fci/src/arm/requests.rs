//! Requests of the client.

use serde::{Deserialize, Serialize};

use super::{Arm, Mode, Motion};
use crate::error::Errors;
use crate::motion::Generator;
use crate::request::{Framed, MoveRequest, MoveStatus, Reply, Request};

/// A request that is executed when the arm is at rest.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) enum Waiting {
    Move(u32, MoveRequest),
    Recovery(u32),
}

/// Number of the command [`Request::Move`].
const MOVE: u32 = 1;
const STOP_MOVE: u32 = 2;
const RECOVERY: u32 = 10;

impl Arm {
    /// Executes a request. Replies follow by [`Arm::take_reply`], that to a motion also later.
    /// `Connect` and `GetRobotModel` are of the connection, and do nothing here.
    pub fn request(&mut self, framed: &Framed) {
        let status = match framed.request {
            Request::Connect { .. } | Request::GetRobotModel => return,
            Request::Move(wanted) => return self.ask_to_move(framed.id, wanted),
            Request::StopMove => return self.stop_move(framed.id),
            Request::AutomaticErrorRecovery => {
                self.memory.waiting = Some(Waiting::Recovery(framed.id));
                return self.serve_waiting();
            }
            _ => self.set(&framed.request),
        };
        self.reply(Reply {
            command: framed.command,
            id: framed.id,
            status,
        });
    }

    /// Executes a setter; its status.
    fn set(&mut self, request: &Request) -> u8 {
        const NOT_POSSIBLE: u8 = 1;
        const INVALID_ARGUMENT: u8 = 2;
        if self.is_moving() {
            return NOT_POSSIBLE;
        }
        let numbers: &[f64] = match request {
            Request::SetEeToK(matrix) | Request::SetNeToEe(matrix) => matrix,
            Request::SetJointImpedance(values) => values,
            Request::SetCartesianImpedance(values) => values,
            Request::SetLoad { center, .. } => center,
            _ => &[],
        };
        if numbers.iter().any(|number| !number.is_finite()) {
            return INVALID_ARGUMENT;
        }
        match request {
            Request::SetEeToK(matrix) => self.memory.stiffness_frame = *matrix,
            Request::SetNeToEe(matrix) => {
                let Ok(pose) = crate::follow::pose_of(matrix) else {
                    return INVALID_ARGUMENT;
                };
                self.memory.nominal_to_end = pose;
                // Without this, states would show the commanded pose of the former end effector
                // until the next motion.
                self.restart_tool();
            }
            Request::SetLoad {
                mass,
                center,
                inertia,
            } => {
                if !(0.0..=10.0).contains(mass) {
                    return INVALID_ARGUMENT;
                }
                self.memory.load = (*mass, *center, *inertia);
            }
            _ => {}
        }
        0
    }

    fn ask_to_move(&mut self, id: u32, wanted: MoveRequest) {
        let known = Generator::of(wanted.generator);
        let is_known = known.is_some_and(|generator| match wanted.controller {
            // An impedance controller without a generator has nothing to follow.
            0 | 1 => generator != Generator::None,
            2 => true,
            _ => false,
        });
        let status = match self.memory.mode {
            _ if !is_known || wanted.is_async => MoveStatus::InvalidArgument,
            Mode::Idle if self.memory.waiting.is_none() => {
                self.memory.waiting = Some(Waiting::Move(id, wanted));
                return self.serve_waiting();
            }
            _ => MoveStatus::NotPossible,
        };
        self.reply_to_move(id, status);
    }

    /// Executes the request that waits, once the arm is at rest: a motion starts from rest, and
    /// a recovery ends the braking of a reflex.
    pub(super) fn serve_waiting(&mut self) {
        if !self.is_at_rest() {
            return;
        }
        match self.memory.waiting.take() {
            Some(Waiting::Move(id, wanted)) => self.start(id, wanted),
            Some(Waiting::Recovery(id)) => {
                // A motion has no error yet.
                if matches!(self.memory.mode, Mode::Reflex) {
                    self.memory.mode = Mode::Idle;
                    self.memory.errors = Errors::default();
                }
                self.reply(Reply {
                    command: RECOVERY,
                    id,
                    status: 0,
                });
            }
            None => {}
        }
    }

    fn start(&mut self, id: u32, wanted: MoveRequest) {
        let Some(generator) = Generator::of(wanted.generator) else {
            return;
        };
        self.memory.mode = Mode::Move(Motion {
            id,
            controller: u8::try_from(wanted.controller).unwrap_or(u8::MAX),
            generator,
            generator_number: u8::try_from(wanted.generator).unwrap_or(u8::MAX),
            is_running: false,
            cycles: 0,
            lost: 0,
        });
        // Not at a recovery: in libfranka these are the errors of the last motion.
        self.memory.reflex_reason = Errors::default();
        self.memory.answered = 0;
        // A client repeats the last command of a motion until a state shows its end: these must not
        // count as answers of the next motion.
        self.memory.answered_id = self.memory.message_id;
        self.memory.answer = None;
        self.memory.start = None;
        self.memory.late = Default::default();
        self.memory.torques = Default::default();
        self.restart_tool();
        self.reply_to_move(id, MoveStatus::Started);
    }

    fn stop_move(&mut self, id: u32) {
        self.end_move(MoveStatus::Preempted);
        self.reply(Reply {
            command: STOP_MOVE,
            id,
            status: 0,
        });
    }

    /// Ends the motion, if there is one, and replies to its request.
    pub(super) fn end_move(&mut self, status: MoveStatus) {
        if let Mode::Move(motion) = self.memory.mode {
            self.memory.mode = Mode::Idle;
            self.memory.torques = Default::default();
            self.reply_to_move(motion.id, status);
        }
    }

    fn reply_to_move(&mut self, id: u32, status: MoveStatus) {
        self.reply(Reply {
            command: MOVE,
            id,
            status: status as u8,
        });
    }

    /// The connection of the client has ended: so does its motion.
    pub fn disconnect(&mut self) {
        self.end_move(MoveStatus::Aborted);
        self.memory.waiting = None;
        self.memory.answer = None;
        self.memory.replies = Default::default();
    }
}
