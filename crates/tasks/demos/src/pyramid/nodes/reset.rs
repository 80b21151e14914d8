//! `FrankaReset`: finds the robot and starts from the observed state.

use std::sync::Arc;
use std::time::Duration;

use behavior::board::{Fault, In, Out};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::{Status, Str};
use ipc_types::GripperGoal;
use robocell_skills::nodes::Context;
use robocell_skills::shared::has_lasted;
use robocell_skills::{Recovery, Station};
use robocell_task::TraceEvent;
use serde::{Deserialize, Serialize};

use crate::pyramid::notes::{self, Notes, Numbers};
use crate::pyramid::setup::Pyramid;

/// The robot has to answer within this many ticks; the sample of Isaac Sim fails in the 30th,
/// too.
const ATTEMPTS: u32 = 30;

/// See the module.
struct FrankaReset {
    settle: In<f64>,
    notes: Notes,
    /// Names of the shared keys of a requested recovery and of a complete stack. Like
    /// `initialized` they are for people and programs that read the blackboard; no node reads
    /// them.
    names: [(Out<Str>, Str); 2],
    initialized: Out<bool>,
    /// Rest pose of the arm, of its TCP.
    rest: Out<Numbers>,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    attempts: u32,
    /// Time since which the gripper has been open.
    settled: Option<Duration>,
    begun: bool,
}

/// The node type.
pub(super) fn node_type(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "FrankaReset",
        "Waits until the arm and its controller answer, takes the stack that is seen \
         for its own, and opens the gripper unless it holds a cube.",
    );
    super::node_type(about, job, FrankaReset::new)
        .aliases(&["FrankaFrankaReset"])
        .keywords(&["begin", "home", "initialise", "open"])
        .input_or(
            "settle",
            0.25,
            "time the open gripper is given to settle (s)",
        )
        .within(0.0, 60.0)
}

impl FrankaReset {
    fn new(notes: Notes, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let named = [
            ("recovery_key", Recovery::key(notes.me.as_str())),
            ("completion_key", notes::complete_key(notes.me)),
        ];
        let mut name = |(key, name): (&str, String)| -> Result<_, BindError> {
            let name = Str::new(&name).unwrap_or_default();
            Ok((notes::local(binder, key, Some(name))?, name))
        };
        let [recovery, completion] = named;
        Ok(Self {
            names: [name(recovery)?, name(completion)?],
            settle: binder.input("settle")?,
            notes,
            initialized: notes::local(binder, "initialized", Some(false))?,
            rest: notes::local(binder, "rest", None)?,
        })
    }

    fn begin(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        self.notes.zone.release(cx)?;
        self.notes.recovery.clear(cx)?;
        for (key, name) in &self.names {
            cx.set(key, *name)?;
        }
        if let Some(arm) = cx.world.arm_setup() {
            cx.set(&self.rest, notes::to_numbers(&arm.wait))?;
        }
        self.notes.compare(cx)?;
        cx.set(&self.initialized, true)
    }
}

impl Leaf<Station> for FrankaReset {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        // The attempts are kept: an arm that does not answer is reported once.
        *state = State {
            attempts: state.attempts,
            ..State::default()
        };
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        if !cx.world.is_alive() {
            state.attempts = state.attempts.saturating_add(1);
            if state.attempts < ATTEMPTS {
                return Ok(Status::Running);
            }
            // Equal, not larger: one report, and failure in every later tick.
            if state.attempts == ATTEMPTS {
                let name = self.notes.me;
                let why = format_args!("[error] {name}: the arm or its controller does not answer");
                cx.world.out.event(TraceEvent::Fault, why);
            }
            return Ok(Status::Failure);
        }
        state.attempts = 0;
        // Once for each start: later it would release the centre while the arm works there.
        if !state.begun {
            state.begun = true;
            self.begin(cx)?;
        }
        // A held cube is not dropped at a start; the tree finds it as the arm's own.
        if cx.world.held().is_some() {
            return Ok(Status::Success);
        }
        cx.world.stay(GripperGoal::Open);
        // A gripper that closes again restarts the time: it has to be open for all of it.
        if !cx.world.is_open() {
            state.settled = None;
            return Ok(Status::Running);
        }
        let since = *state.settled.get_or_insert(cx.now);
        Ok(if has_lasted(since, cx.now, cx.get(&self.settle)?) {
            Status::Success
        } else {
            Status::Running
        })
    }
}
