//! The world with its clock switch: pause, step, script and the end of a run.
//!
//! [`Plant`] is the common part of the physics process and of the cell in one process: both
//! call [`Plant::before_step`] at each tick boundary, and step if it says so. These rules make
//! their runs equal to the bit:
//!
//! - Pause, end and script lines take effect at a tick boundary, as a function of the tick and
//!   of the newest decision, never of a clock.
//! - The end of a run is decided here, not by the launcher, which would be some ticks late or
//!   early (ADR 0005).
//! - Requests change levels and counters of the panel, so a reader that missed a state misses
//!   no request (ADR 0001).
//! - A field that decides the next tick has to be in [`Plant::save`]. A successor that lacks
//!   it continues differently: the breakpoint that was reached last paused a cell a second
//!   time when it was missing.

mod saved;
mod script;

use cell_model::Cell;
use cell_model::cells::script::{ScriptAction, ScriptRunner};
use cell_run::script_report::ScriptReply;
use cell_run::spec::{RunSpec, Speed};
use ipc_types::decision::Outcome;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED, PauseCause};
use ipc_types::{Decision, Header, OperatorReply, OperatorRequest, TICK_NS, Text, WorldState};

use crate::operator::requests::Reply;
use crate::resume::due::Switches;
use crate::world::{StepInput, World, WorldError};

/// The action at a tick boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Simulate the next tick.
    Step,
    /// Publish the same tick again: paused, ended, or waiting for the launcher.
    Wait,
}

/// The world, and whether simulated time passes.
pub struct Plant {
    world: World,
    script: ScriptRunner,
    objects: Vec<String>,
    arms: Vec<String>,
    speed: Speed,
    until_done: bool,
    limit_tick: u64,
    pause: Option<PauseCause>,
    steps_left: Option<u64>,
    ending: bool,
    /// A script line that the launcher has to execute.
    waiting: Option<(u32, ScriptAction)>,
    /// Replies to the lines so far.
    replies: Vec<ScriptReply>,
    /// Policy at the start of the run.
    policy: String,
    /// Accepted requests, except drags, which a page repeats up to 30 times a second.
    requests: u64,
    /// Number of the last accepted request that a successor of this process has to repeat.
    accepted: u64,
    /// Tick this start of physics began with.
    resumed_tick: u64,
    /// Tick at which the task reached the breakpoint that paused last.
    break_tick: u64,
}

impl Plant {
    /// Sets the scene of `cell` up for the run `spec`.
    pub fn new(cell: &Cell, spec: &RunSpec) -> Result<Self, WorldError> {
        let mut world = World::new(cell)?;
        if spec.until_done {
            // No other process gives the start event to a run that ends by itself.
            let start = OperatorRequest::zeroed_at_identity();
            let _accepted = world.execute_request(OperatorAction::TaskStart, &start);
        }
        Ok(Self {
            world,
            script: ScriptRunner::new(&spec.script),
            objects: cell.objects.iter().map(|o| o.name.clone()).collect(),
            arms: cell.arms.iter().map(|arm| arm.name.clone()).collect(),
            speed: spec.speed,
            until_done: spec.until_done,
            limit_tick: spec.time_limit_s.map_or(u64::MAX, ticks),
            pause: spec.paused.then_some(PauseCause::Start),
            steps_left: None,
            ending: false,
            waiting: None,
            replies: Vec::new(),
            policy: spec.policy.clone(),
            requests: 0,
            accepted: 0,
            resumed_tick: 0,
            break_tick: 0,
        })
    }

    /// See [`World::make_ideal`].
    pub(crate) fn make_ideal(&mut self) {
        self.world.make_ideal();
    }

    /// State of the operator's switches.
    pub(crate) fn switches(&self) -> Switches {
        Switches {
            paused: self.pause.is_some(),
            requests: self.requests,
        }
    }

    /// Decisions older than this stop the belt (ticks).
    pub fn set_decision_limit(&mut self, ticks: u64) {
        self.world.set_decision_limit(ticks);
    }

    /// Speed of simulated time.
    pub(crate) fn speed(&self) -> Speed {
        self.speed
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Runs the script and returns whether to step. `decision` is the newest one caused by the
    /// present tick or an earlier one.
    pub fn before_step(&mut self, decision: Option<&Decision>) -> Next {
        // Script first: a line of this tick may pause, and takes effect before the step. The
        // breakpoint is last, so it replaces the cause of a pause.
        self.run_script(decision);
        self.check_end(decision);
        self.check_break(decision);
        // A kill at a tick of the script has to happen at that tick in every run: in lockstep
        // time waits for the launcher. In real time nothing waits.
        let held = self.waiting.is_some() && self.speed.is_lockstep();
        if self.pause.is_some() || self.ending || held {
            return Next::Wait;
        }
        if let Some(left) = self.steps_left {
            // The step that uses up the count also pauses, so that exactly this many ticks
            // pass.
            self.steps_left = left.checked_sub(1).filter(|left| *left > 0);
            self.pause = self.steps_left.is_none().then_some(PauseCause::Step);
        }
        Next::Step
    }

    /// Simulates one tick.
    pub fn step(&mut self, input: &StepInput<'_>) {
        self.world.step(input);
    }

    /// Writes the present state, except for the fields that the publisher stamps.
    pub fn write_state(&self, state: &mut WorldState) {
        self.world.write_state(state);
        state.panel.pause_cause = self.pause_cause();
        state.panel.speed = self.speed.factor();
        state.flags = if self.pause.is_some() { FLAG_PAUSED } else { 0 }
            | if self.speed.is_lockstep() {
                FLAG_LOCKSTEP
            } else {
                0
            }
            | if self.ending { FLAG_ENDING } else { 0 };
        state.script_line = self.waiting.as_ref().map_or(0, |(line, _)| *line);
        state.script_left = self.script.left();
        state.resumed_tick = self.resumed_tick;
    }

    /// The script line that the launcher has to execute.
    pub fn waiting(&self) -> Option<&(u32, ScriptAction)> {
        self.waiting.as_ref()
    }

    /// Replies to the script lines that were due.
    pub fn script_replies(&self) -> &[ScriptReply] {
        &self.replies
    }

    /// Whether the run has come to its end.
    pub fn is_ending(&self) -> bool {
        self.ending
    }

    /// Answers a request of the operator: the plant executes the requests to its clock, the
    /// world all others.
    pub fn answer_request(&mut self, request: &OperatorRequest) -> OperatorReply {
        let (code, message) = match action_of(request) {
            None => (
                ReplyCode::OutOfRange,
                format!("action {} is unknown", request.action),
            ),
            Some(action) => match self.set_clock(action, request) {
                Some(reply) => reply,
                None => self.world.execute_request(action, request),
            },
        };
        let message = self.with_pause(action_of(request), code, message);
        // A page repeats a drag up to 30 times a second: counting it would save a state every 100
        // ticks.
        let is_frequent = request.action == OperatorAction::Drag.code();
        let is_accepted = code == ReplyCode::Accepted && has_effect(request);
        self.requests += u64::from(is_accepted && !is_frequent);
        self.accepted += u64::from(is_accepted);
        let is_step = request.action == OperatorAction::Step.code();
        // Only a request for steps reports the tick at which they end.
        let left = self.steps_left.filter(|_| is_step);
        let until_tick = left.map_or(0, |left| self.world.tick() + left);
        OperatorReply {
            header: Header::caused_by::<OperatorReply>(self.world.tick()),
            code: code.code(),
            reserved: 0,
            until_tick,
            message: Text::new(&message),
        }
    }

    /// Adds to `message` that simulated time is paused if an accepted request has no effect
    /// until it is resumed.
    fn with_pause(
        &self,
        action: Option<OperatorAction>,
        code: ReplyCode,
        message: String,
    ) -> String {
        let needs_time = matches!(
            action,
            Some(
                OperatorAction::TaskStart
                    | OperatorAction::TaskResume
                    | OperatorAction::TaskReset
                    | OperatorAction::Reset
                    | OperatorAction::DropParts
                    | OperatorAction::AddBin
                    | OperatorAction::Gripper
            )
        );
        if !needs_time || code != ReplyCode::Accepted || self.pause.is_none() {
            return message;
        }
        if message.is_empty() {
            return "simulated time is paused until `robocell resume`".to_owned();
        }
        // A message has room for 120 bytes.
        message + "; time is paused, too"
    }

    /// Executes a request to the clock; `None` for any other one.
    fn set_clock(&mut self, action: OperatorAction, request: &OperatorRequest) -> Option<Reply> {
        match action {
            OperatorAction::Ping => {}
            OperatorAction::Pause => self.pause(),
            OperatorAction::Resume => self.resume(),
            OperatorAction::Step => {
                let left = self.steps_left.unwrap_or(0);
                self.pause = None;
                self.steps_left = Some(left + u64::from(request.count.max(1)));
            }
            OperatorAction::ScriptDone => {
                // The number is compared: an answer to another line must not end the wait for
                // this one.
                let done = self.waiting.take_if(|(line, _)| *line == request.count);
                if let Some((line, action)) = done {
                    if let ScriptAction::Pause { .. } = action {
                        self.resume();
                    }
                    self.note_script(line, &action, Ok(()));
                }
            }
            OperatorAction::Speed => match Speed::of_factor(request.seconds) {
                Some(speed) => self.speed = speed,
                None => return Some(wrong_speed(request.seconds)),
            },
            OperatorAction::End => self.ending = true,
            _ => return None,
        }
        Some((ReplyCode::Accepted, String::new()))
    }

    fn pause_cause(&self) -> u32 {
        self.pause.unwrap_or(PauseCause::None).code()
    }

    fn resume(&mut self) {
        self.pause = None;
        self.steps_left = None;
    }

    fn pause(&mut self) {
        self.pause = Some(PauseCause::Operator);
        self.steps_left = None;
    }

    fn check_end(&mut self, decision: Option<&Decision>) {
        let outcome = decision.and_then(|d| Outcome::from_code(d.outcome));
        let done = matches!(outcome, Some(Outcome::Done | Outcome::Failed));
        self.ending |= (self.until_done && done) || self.world.tick() >= self.limit_tick;
    }

    /// Pauses at a breakpoint that the task had not reported before.
    fn check_break(&mut self, decision: Option<&Decision>) {
        let reached = decision.map_or(0, |decision| decision.break_tick);
        // The task repeats the tick in every decision; only a change is a new breakpoint.
        if reached != 0 && std::mem::replace(&mut self.break_tick, reached) != reached {
            self.pause = Some(PauseCause::Breakpoint);
            self.steps_left = None;
        }
    }
}

/// Whether a state after `request` differs from one before it.
pub(crate) fn has_effect(request: &OperatorRequest) -> bool {
    !matches!(
        action_of(request),
        None | Some(OperatorAction::Ping | OperatorAction::ScriptDone)
    )
}

fn action_of(request: &OperatorRequest) -> Option<OperatorAction> {
    OperatorAction::from_code(request.action)
}

fn wrong_speed(factor: f64) -> Reply {
    let allowed = "0 (as fast as possible), 1 (real time), or 0.01 to 50";
    (
        ReplyCode::OutOfRange,
        format!("speed is {factor}; allowed are {allowed}"),
    )
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "time limits are checked to be positive and below 1e6 s"
)]
fn ticks(seconds: f64) -> u64 {
    (seconds * 1.0e9 / TICK_NS as f64).round() as u64
}
