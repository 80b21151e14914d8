//! The world with its clock switch: pause, step, script and the end of a run.
//!
//! [`Plant`] is what the physics process and the one-process cell have in
//! common: both ask [`Plant::before_step`] what to do at a tick, and step.

mod saved;

use cell_model::Cell;
use cell_model::cells::script::{GripperWord, ScriptAction, ScriptRunner};
use cell_model::runs::script_report::ScriptReply;
use cell_model::runs::spec::{RunSpec, Speed};
use ipc_types::decision::Outcome;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED, PauseCause};
use ipc_types::{
    Decision, GripperGoal, Header, OperatorReply, OperatorRequest, Pose, TICK_NS, Text, WorldState,
};

use crate::resume::Switches;
use crate::world::{StepInput, World, WorldError};

/// The policy that goes where the operator points, paused or not.
const FOLLOWS: &str = "follow";

/// What to do at a tick boundary.
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
    /// A script line the launcher has to act on.
    waiting: Option<(u32, ScriptAction)>,
    /// What became of the lines so far.
    replies: Vec<ScriptReply>,
    /// Policy the run began with.
    policy: String,
    /// Requests obeyed, but for those that come with every frame of a page.
    requests: u64,
    /// Requests obeyed that another start of physics has to obey, too: their number.
    accepted: u64,
    /// Tick this start of physics began with.
    resumed_tick: u64,
    /// When the task reached the breakpoint that paused last.
    break_tick: u64,
}

impl Plant {
    /// Sets the scene of `cell` up for the run `spec`.
    pub fn new(cell: &Cell, spec: &RunSpec) -> Result<Self, WorldError> {
        let mut world = World::new(cell)?;
        if spec.until_done {
            // No other process gives the start event to a run that ends by itself.
            let start = OperatorRequest::zeroed_at_identity();
            let _accepted = world.operate(OperatorAction::TaskStart, &start);
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

    /// What people switched.
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

    /// How simulated time goes.
    pub(crate) fn speed(&self) -> Speed {
        self.speed
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Acts on the script and says whether to step. `decision` is the newest
    /// one caused by the present tick or earlier.
    pub fn before_step(&mut self, decision: Option<&Decision>) -> Next {
        self.run_script(decision);
        self.check_end(decision);
        self.check_break(decision);
        let held = self.waiting.is_some() && self.speed.is_lockstep();
        if self.pause.is_some() || self.ending || held {
            return Next::Wait;
        }
        if let Some(left) = self.steps_left {
            self.steps_left = left.checked_sub(1).filter(|left| *left > 0);
            self.pause = self.steps_left.is_none().then_some(PauseCause::Step);
        }
        Next::Step
    }

    /// Simulates one tick.
    pub fn step(&mut self, input: &StepInput<'_>) {
        self.world.step(input);
    }

    /// Writes the present state, all but what the publisher stamps.
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

    /// The script line the launcher has to act on.
    pub fn waiting(&self) -> Option<&(u32, ScriptAction)> {
        self.waiting.as_ref()
    }

    /// What became of the lines of the script that were due.
    pub fn script_replies(&self) -> &[ScriptReply] {
        &self.replies
    }

    /// Whether the run has come to its end.
    pub fn is_ending(&self) -> bool {
        self.ending
    }

    /// Acts on a request and answers it.
    pub fn operate(&mut self, request: &OperatorRequest) -> OperatorReply {
        let reply = self.answer(request);
        let is_accepted = reply.code == ReplyCode::Accepted.code();
        self.accepted += u64::from(is_accepted && has_effect(request));
        reply
    }

    /// As [`Plant::operate`], for a request that a successor makes again by itself.
    fn answer(&mut self, request: &OperatorRequest) -> OperatorReply {
        let (code, message) = match action_of(request) {
            None => (
                ReplyCode::OutOfRange,
                format!("action {} is unknown", request.action),
            ),
            Some(action) => self.act(action, request),
        };
        let message = self.with_pause(action_of(request), code, message);
        // One comes with every frame of a page.
        let is_frequent = request.action == OperatorAction::Drag.code();
        let is_counted = code == ReplyCode::Accepted && has_effect(request) && !is_frequent;
        self.requests += u64::from(is_counted);
        let is_step = request.action == OperatorAction::Step.code();
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

    /// A `message` that also says that simulated time is paused, where an accepted request has
    /// no effect until it is resumed.
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

    fn act(&mut self, action: OperatorAction, request: &OperatorRequest) -> (ReplyCode, String) {
        match action {
            OperatorAction::Ping => {}
            OperatorAction::Pause => self.pause(),
            OperatorAction::Resume => {
                self.pause = None;
                self.steps_left = None;
            }
            OperatorAction::Step => {
                let left = self.steps_left.unwrap_or(0);
                self.pause = None;
                self.steps_left = Some(left + u64::from(request.count.max(1)));
            }
            OperatorAction::ScriptDone => {
                let done = self.waiting.take_if(|(line, _)| *line == request.count);
                if let Some((line, action)) = done {
                    self.note_script(line, &action, Ok(()));
                }
            }
            OperatorAction::Speed => match Speed::of_factor(request.seconds) {
                Some(speed) => self.speed = speed,
                None => return wrong_speed(request.seconds),
            },
            OperatorAction::End => self.ending = true,
            other => return self.world.operate(other, request),
        }
        (ReplyCode::Accepted, String::new())
    }

    fn pause_cause(&self) -> u32 {
        self.pause.unwrap_or(PauseCause::None).code()
    }

    fn pause(&mut self) {
        self.pause = Some(PauseCause::Operator);
        self.steps_left = None;
    }

    fn run_script(&mut self, decision: Option<&Decision>) {
        let tick = self.world.tick();
        if let Some(decision) = decision {
            self.script.observe(
                tick,
                decision.phase.as_str(),
                decision.phase_entry,
                &self.arms,
            );
        }
        while self.waiting.is_none() {
            let Some((line, action)) = self.script.next_due(tick) else {
                return;
            };
            if action.is_for_launcher() {
                self.waiting = Some((line, action));
            } else {
                let reply = self.obey_script(&action, decision);
                self.note_script(line, &action, reply);
            }
        }
    }

    fn obey_script(
        &mut self,
        action: &ScriptAction,
        decision: Option<&Decision>,
    ) -> Result<(), String> {
        let policy = decision.map_or("", |decision| decision.policy.as_str());
        let policy = if policy.is_empty() {
            &self.policy
        } else {
            policy
        };
        let led = action.leads() && policy != FOLLOWS && !self.world.operator_leads();
        if led {
            return Err("the task leads the arm; `task_pause` gives it to the operator".to_owned());
        }
        let request = self.request_of(action);
        let request = request.ok_or_else(|| "this cell has no such object or arm".to_owned())?;
        let reply = self.answer(&request);
        match ReplyCode::from_code(reply.code) {
            Some(ReplyCode::Accepted) => Ok(()),
            _ => Err(reply.message.as_str().to_owned()),
        }
    }

    fn note_script(&mut self, line: u32, action: &ScriptAction, reply: Result<(), String>) {
        self.replies.push(ScriptReply {
            line,
            at_s: (self.world.tick() * TICK_NS) as f64 * 1.0e-9,
            action: action.name(),
            accepted: reply.is_ok(),
            reason: reply.err(),
        });
    }

    fn check_end(&mut self, decision: Option<&Decision>) {
        let outcome = decision.and_then(|d| Outcome::from_code(d.outcome));
        let done = matches!(outcome, Some(Outcome::Done | Outcome::Failed));
        self.ending |= (self.until_done && done) || self.world.tick() >= self.limit_tick;
    }

    /// The task reached a breakpoint that it had not reached before.
    fn check_break(&mut self, decision: Option<&Decision>) {
        let reached = decision.map_or(0, |decision| decision.break_tick);
        if reached != 0 && std::mem::replace(&mut self.break_tick, reached) != reached {
            self.pause = Some(PauseCause::Breakpoint);
            self.steps_left = None;
        }
    }

    fn request_of(&self, action: &ScriptAction) -> Option<OperatorRequest> {
        let mut request = OperatorRequest::zeroed_at_identity();
        let code = match action {
            ScriptAction::Drag { object, to, for_s } => {
                request.object = index_of(&self.objects, object)?;
                request.pose.position = *to;
                request.seconds = *for_s;
                OperatorAction::Drag
            }
            ScriptAction::Gripper { to, arm } => {
                request.arm = *arm;
                request.count = match to {
                    GripperWord::Open => GripperGoal::Open.code(),
                    GripperWord::Close => GripperGoal::Close.code(),
                };
                OperatorAction::Gripper
            }
            ScriptAction::Target {
                position,
                orientation_wxyz,
                arm,
            } => {
                request.arm = *arm;
                let present = || self.world.present_orientation(*arm);
                request.pose = unit(&Pose {
                    position: *position,
                    orientation_wxyz: orientation_wxyz.or_else(present)?,
                });
                OperatorAction::Target
            }
            ScriptAction::DropParts { count } => {
                request.count = *count;
                OperatorAction::DropParts
            }
            ScriptAction::AddBin { flipped } => {
                request.count = u32::from(*flipped);
                OperatorAction::AddBin
            }
            ScriptAction::TaskStart {} => OperatorAction::TaskStart,
            ScriptAction::TaskPause {} => OperatorAction::TaskPause,
            ScriptAction::TaskResume {} => OperatorAction::TaskResume,
            ScriptAction::TaskReset {} => OperatorAction::TaskReset,
            ScriptAction::Pause {} => OperatorAction::Pause,
            ScriptAction::Resume {} => OperatorAction::Resume,
            ScriptAction::Reset {} => OperatorAction::Reset,
            ScriptAction::Kill { .. } | ScriptAction::Stop { .. } => return None,
        };
        request.action = code.code();
        Some(request)
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

/// With an orientation of length 1: people round.
fn unit(pose: &Pose) -> Pose {
    let [w, x, y, z] = pose.orientation_wxyz;
    let length = [w, x, y, z].iter().map(|q| q * q).sum::<f64>().sqrt();
    Pose {
        orientation_wxyz: pose.orientation_wxyz.map(|q| q / length),
        ..*pose
    }
}

fn wrong_speed(factor: f64) -> (ReplyCode, String) {
    let allowed = "0 (as fast as it goes), 1 (real time), or 0.01 to 50";
    (
        ReplyCode::OutOfRange,
        format!("speed is {factor}; allowed are {allowed}"),
    )
}

fn index_of(names: &[String], name: &str) -> Option<u32> {
    let index = names.iter().position(|n| n == name)?;
    u32::try_from(index).ok()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "time limits are checked to be positive and below 1e6 s"
)]
fn ticks(seconds: f64) -> u64 {
    (seconds * 1.0e9 / TICK_NS as f64).round() as u64
}
