//! `FrankaReset`: finds the robot and begins with what is seen.

use behavior::Status;
use behavior::Str;
use behavior::board::{Access, Fault, In, Out};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use ipc_types::GripperGoal;
use robocell_task::TraceEvent;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

use super::seconds;
use crate::pyramid::center::Center;
use crate::pyramid::cubes::Cubes;
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::{self, Recovery};
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::{Numbers, to_numbers};

/// The robot has to be found at one of so many ticks.
const ATTEMPTS: u32 = 30;

/// See the module.
struct FrankaReset {
    settle: In<f64>,
    cubes: Cubes,
    center: Center,
    recovery: Recovery,
    recovery_key: Out<Str>,
    completion_key: Out<Str>,
    initialized: Out<bool>,
    rest: Out<Numbers>,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    attempts: u32,
    /// Since when the hand is as it shall be.
    settled: Option<Duration>,
    begun: bool,
}

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "FrankaReset",
        "Waits until the arm and its controller answer, takes the stack that is \
         there for its own, and opens the hand unless it holds a cube.",
        move |binder| FrankaReset::new(&setup, binder),
    )
    .aliases(&["FrankaFrankaReset"])
    .keywords(&["begin", "home", "initialise", "open"])
    .input_or("settle", 0.25, "time the open hand has to rest (s)")
    .within(0.0, 60.0)
}

impl FrankaReset {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        let robot = keys::robot(binder)?;
        let name = |text: &str| Some(Str::new(text).unwrap_or_default());
        let recovery_key = name(&keys::recovery_requested(robot.as_str()));
        let completion_key = name(&keys::stack_complete(robot.as_str()));
        Ok(Self {
            settle: binder.input("settle")?,
            cubes: Cubes::bind(setup, binder)?,
            center: Center::bind(binder)?,
            recovery: Recovery::bind(binder)?,
            recovery_key: keys::local(binder, keys::RECOVERY_KEY, recovery_key, Access::Write)?,
            completion_key: keys::local(
                binder,
                keys::COMPLETION_KEY,
                completion_key,
                Access::Write,
            )?,
            initialized: keys::local(binder, keys::INITIALIZED, Some(false), Access::Write)?,
            rest: keys::local(binder, keys::REST, None, Access::Write)?,
        })
    }

    fn begin(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        self.center.release(cx)?;
        self.recovery.clear(cx)?;
        let robot = self.cubes.me();
        let name = |text: String| Str::new(&text).unwrap_or_default();
        // Once a job, so building the names may use the heap.
        cx.set(
            &self.recovery_key,
            name(keys::recovery_requested(robot.as_str())),
        )?;
        cx.set(
            &self.completion_key,
            name(keys::stack_complete(robot.as_str())),
        )?;
        if let Some(rest) = cx.world.rest() {
            cx.set(&self.rest, to_numbers(&rest))?;
        }
        self.cubes.compare(cx)?;
        cx.set(&self.initialized, true)
    }
}

impl Leaf<PyramidHost> for FrankaReset {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        // The attempts count on: an arm that stays silent is said to once.
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
            if state.attempts == ATTEMPTS {
                let name = cx.world.name();
                cx.world.out.event(
                    TraceEvent::Fault,
                    format_args!("[error] {name}: the arm or its controller does not answer"),
                );
            }
            return Ok(Status::Failure);
        }
        state.attempts = 0;
        if !state.begun {
            state.begun = true;
            self.begin(cx)?;
        }
        if cx.world.cube_in_hand().is_some() {
            return Ok(Status::Success);
        }
        cx.world.grip(GripperGoal::Open);
        if !cx.world.is_open() {
            state.settled = None;
            return Ok(Status::Running);
        }
        let since = *state.settled.get_or_insert(cx.now);
        let rested = cx.now.saturating_sub(since) >= seconds(cx.get(&self.settle)?);
        Ok(if rested {
            Status::Success
        } else {
            Status::Running
        })
    }
}
