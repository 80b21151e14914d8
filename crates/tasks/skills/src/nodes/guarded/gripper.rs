//! `SetGripper`: opens or closes the gripper and waits for it.

use std::time::Duration;

use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::{Status, Str};
use ipc_types::GripperGoal;
use robocell_task::TraceEvent;
use serde::{Deserialize, Serialize};

use super::{Context, Guard, WorkKeys, guarded};
use crate::grip;
use crate::progress::Step;
use crate::setup::Tool;
use crate::shared::{Alarm, Turn, has_lasted};
use crate::skill::Station;

/// Fingers slower than this are at rest (m/s).
const REST_M_S: f64 = 0.002;
/// A warning is given each time the gripper did not obey for this long (s).
const WARNING_S: f64 = 5.0;

/// See the module.
struct SetGripper {
    command: In<Str>,
    pre_open: In<f64>,
    pre_close: In<f64>,
    settle: In<f64>,
    guard: Guard,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    turn: Turn,
    begun: Option<Duration>,
    told: Option<Duration>,
    alarm: Alarm,
    /// The wait before suction is switched on.
    step: Step,
}

/// The node type.
pub(super) fn node_type(keys: WorkKeys) -> NodeType<Station> {
    let node_type = NodeType::new(
        "SetGripper",
        "Waits, opens or closes the gripper, and waits until it is at rest. Closing \
         asks for a recovery when the object moved before, or was not caught.",
        move |binder| SetGripper::new(binder, keys),
    )
    .aliases(&["FrankaSetGripper"])
    .keywords(&["hand", "fingers", "open", "close", "grasp", "release"])
    .input::<Str>("command", "command to the gripper")
    .one_of(&["open", "close"])
    .input_or("pre_open", 0.25, "time before it opens (s)")
    .within(0.0, 60.0)
    .input_or("pre_close", 0.25, "time before it closes (s)")
    .within(0.0, 60.0)
    .input_or("settle", 0.25, "time it has at least (s)")
    .within(0.0, 60.0);
    guarded(node_type)
}

impl SetGripper {
    fn new(binder: &mut Binder<'_>, keys: WorkKeys) -> Result<Self, BindError> {
        Ok(Self {
            command: binder.input("command")?,
            pre_open: binder.input("pre_open")?,
            pre_close: binder.input("pre_close")?,
            settle: binder.input("settle")?,
            guard: Guard::bind(binder, keys)?,
        })
    }

    /// What became of the command, once the gripper has had its time.
    fn outcome(
        &self,
        state: &mut State,
        gripper: GripperGoal,
        cx: &mut Context<'_, '_>,
    ) -> Result<Status, Fault> {
        let arm = cx.world.observation.arm(cx.world.arm);
        let at_rest = arm.is_some_and(|a| a.gripper.width_velocity.abs() < REST_M_S);
        let obeyed = match gripper {
            GripperGoal::Open => cx.world.is_open(),
            _ => at_rest,
        };
        if !obeyed {
            if state.alarm.is_due(cx.now, WARNING_S) {
                let name = cx.world.arm_name();
                let out = &mut *cx.world.out;
                out.log(format_args!("[warning] {name}: the gripper does not obey"));
            }
            return Ok(Status::Running);
        }
        let object = self.guard.object(cx)?;
        let held = cx.world.held();
        if gripper == GripperGoal::Close && object.is_some() && held != object {
            let setup = cx.world.setup;
            let on = held.map_or("nothing", |held| setup.object_name(held));
            let recovery = &self.guard.recovery;
            recovery.request(cx, format_args!("the gripper closed on {on}"))?;
            return Ok(Status::Running);
        }
        Ok(Status::Success)
    }
}

impl Leaf<Station> for SetGripper {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = State::default();
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        if self.guard.skips(cx)? {
            return Ok(Status::Success);
        }
        let command = cx.get(&self.command)?;
        let (gripper, before) = match command.as_str() {
            "open" => (GripperGoal::Open, cx.get(&self.pre_open)?),
            "close" => (GripperGoal::Close, cx.get(&self.pre_close)?),
            other => {
                let why = format_args!("[error] '{other}' is not a command; open and close are");
                cx.world.out.event(TraceEvent::Fault, why);
                return Ok(Status::Failure);
            }
        };
        // Until the fingers were told to close the object is where they are going.
        let approaches = gripper == GripperGoal::Close && state.told.is_none();
        if approaches && self.guard.has_moved(cx)? {
            cx.world.hold();
            return Ok(Status::Running);
        }
        if !self.guard.may_work(&mut state.turn, cx)? {
            return Ok(Status::Running);
        }
        let begun = *state.begun.get_or_insert(cx.now);
        if !has_lasted(begun, cx.now, before) {
            cx.world.stay(GripperGoal::Keep);
            return Ok(Status::Running);
        }
        // A cup searches once, when suction is switched on, and needs a tool at rest.
        let switches = gripper == GripperGoal::Close && cx.world.tool() == Tool::Suction;
        if switches && state.told.is_none() && cx.world.held().is_none() {
            cx.world.begin(&mut state.step);
            if !grip::switches_on(&mut state.step, cx.world) {
                return Ok(Status::Running);
            }
        }
        cx.world.stay(gripper);
        let told = *state.told.get_or_insert(cx.now);
        if !has_lasted(told, cx.now, cx.get(&self.settle)?) {
            return Ok(Status::Running);
        }
        self.outcome(state, gripper, cx)
    }
}
