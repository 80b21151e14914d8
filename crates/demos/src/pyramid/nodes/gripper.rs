//! `SetGripper`: opens or closes the hand and waits for it.

use robocell_task::TraceEvent;
use std::time::Duration;

use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use behavior::{Status, Str};
use ipc_types::GripperGoal;
use serde::{Deserialize, Serialize};

use super::watch::Watch;
use super::{Alarm, Turn, seconds};
use crate::pyramid::host::{Context, PyramidHost};

/// Fingers slower than this stand (m/s).
const STANDING_M_S: f64 = 0.002;
/// A warning is given each time the hand did not obey for this long (s).
const WARNING_S: f64 = 5.0;

/// See the module.
struct SetGripper {
    command: In<Str>,
    pre_open: In<f64>,
    pre_close: In<f64>,
    settle: In<f64>,
    movement: In<f64>,
    skip_when_held: In<bool>,
    in_center: In<bool>,
    watch: Watch,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    key: u64,
    turn: Turn,
    begun: Option<Duration>,
    told: Option<Duration>,
    alarm: Alarm,
}

/// The node type.
pub(in crate::pyramid) fn node_type() -> NodeType<PyramidHost> {
    NodeType::new(
        "SetGripper",
        "Waits, opens or closes the hand, and waits until it stands. Closing \
         asks for a recovery when the cube moved before, or was not caught.",
        SetGripper::new,
    )
    .aliases(&["FrankaSetGripper"])
    .keywords(&["hand", "fingers", "open", "close", "grasp", "release"])
    .input::<Str>("command", "what the hand shall do")
    .one_of(&["open", "close"])
    .input_or("pre_open", 0.25, "time before it opens (s)")
    .within(0.0, 60.0)
    .input_or("pre_close", 0.25, "time before it closes (s)")
    .within(0.0, 60.0)
    .input_or("settle", 0.25, "time it has at least (s)")
    .within(0.0, 60.0)
    .input_or("movement", 0.008, "a cube that moved further has moved (m)")
    .within(1.0e-4, 1.0)
    .also(&["movement_tolerance"])
    .input_or(
        "skip_when_held",
        false,
        "succeeds at once when the cube is in the hand already",
    )
    .input_or(
        "in_center",
        false,
        "works in the centre: waits while another arm owns it",
    )
}

impl SetGripper {
    fn new(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            command: binder.input("command")?,
            pre_open: binder.input("pre_open")?,
            pre_close: binder.input("pre_close")?,
            settle: binder.input("settle")?,
            movement: binder.input("movement")?,
            skip_when_held: binder.input("skip_when_held")?,
            in_center: binder.input("in_center")?,
            watch: Watch::bind(binder)?,
        })
    }

    /// The cube is still where the fingers go, until they were told to close.
    fn has_slipped_away(
        &self,
        state: &State,
        gripper: GripperGoal,
        cx: &mut Context<'_, '_>,
    ) -> Result<bool, Fault> {
        let movement = cx.get(&self.movement)?;
        Ok(gripper == GripperGoal::Close
            && state.told.is_none()
            && self.watch.has_moved(cx, movement)?)
    }

    /// How it stands once the fingers were told.
    fn outcome(
        &self,
        state: &mut State,
        gripper: GripperGoal,
        cx: &mut Context<'_, '_>,
    ) -> Result<Status, Fault> {
        let arm = cx.world.observation.arm(cx.world.arm);
        let stands = arm.is_some_and(|a| a.gripper.width_velocity.abs() < STANDING_M_S);
        let obeyed = match gripper {
            GripperGoal::Open => cx.world.is_open(),
            _ => stands,
        };
        if !obeyed {
            if state.alarm.is_due(cx.now, WARNING_S) {
                let name = cx.world.name();
                cx.world
                    .out
                    .log(format_args!("[warning] {name}: the hand does not obey"));
            }
            return Ok(Status::Running);
        }
        if gripper == GripperGoal::Close
            && self.watch.cube(cx)?.is_some()
            && !self.watch.holds(cx)?
        {
            let caught = cx.world.cube_in_hand();
            let name = caught.map(|cube| cx.world.setup.cube_name(cube));
            let on = name.as_ref().map_or("nothing", Str::as_str);
            self.watch
                .recovery
                .request(cx, format_args!("the hand closed on {on}"))?;
            return Ok(Status::Running);
        }
        Ok(Status::Success)
    }
}

impl Leaf<PyramidHost> for SetGripper {
    type State = State;

    fn start(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = State {
            key: cx.world.new_key(),
            ..State::default()
        };
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        if cx.get(&self.skip_when_held)? && self.watch.holds(cx)? {
            return Ok(Status::Success);
        }
        let command = cx.get(&self.command)?;
        let (gripper, before) = match command.as_str() {
            "open" => (GripperGoal::Open, cx.get(&self.pre_open)?),
            "close" => (GripperGoal::Close, cx.get(&self.pre_close)?),
            other => {
                cx.world.out.event(
                    TraceEvent::Fault,
                    format_args!("[error] '{other}' is no command of a hand; open and close are"),
                );
                return Ok(Status::Failure);
            }
        };
        if self.has_slipped_away(state, gripper, cx)? {
            return Ok(Status::Running);
        }
        if cx.get(&self.in_center)? && !state.turn.comes(&self.watch.center, state.key, cx)? {
            return Ok(Status::Running);
        }
        let begun = *state.begun.get_or_insert(cx.now);
        if cx.now.saturating_sub(begun) < seconds(before) {
            cx.world.grip(GripperGoal::Keep);
            return Ok(Status::Running);
        }
        cx.world.grip(gripper);
        let told = *state.told.get_or_insert(cx.now);
        if cx.now.saturating_sub(told) < seconds(cx.get(&self.settle)?) {
            return Ok(Status::Running);
        }
        self.outcome(state, gripper, cx)
    }
}
