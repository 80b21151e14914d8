//! `MoveToTarget`: brings the TCP to one of the targets.

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::watch::Watch;
use super::{Alarm, Turn};
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::targets::{Numbers, from_numbers};
use crate::stack::geometry;

/// See the module.
struct MoveToTarget {
    target: In<Numbers>,
    position_tolerance: In<f64>,
    orientation_tolerance: In<f64>,
    use_target_orientation: In<bool>,
    yaw: In<f64>,
    monitor_pickup_motion: In<bool>,
    monitor_grasp: In<bool>,
    movement: In<f64>,
    max_grasp_distance: In<f64>,
    warning: In<f64>,
    straight_lead: In<f64>,
    skip_when_held: In<bool>,
    in_center: In<bool>,
    watch: Watch,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    key: u64,
    alarm: Alarm,
    missed: u32,
    turn: Turn,
    /// Where the TCP was at first (m).
    from: Option<[f64; 3]>,
}

/// The node type.
pub(in crate::pyramid) fn node_type() -> NodeType<PyramidHost> {
    let node_type = NodeType::new(
        "MoveToTarget",
        "Moves the TCP to a target. It may watch the cube it goes for, or the \
         one it carries, and asks for a recovery when that one moved.",
        MoveToTarget::new,
    )
    .aliases(&["FrankaMoveToTarget"])
    .keywords(&["motion", "reach", "pose", "go"])
    .input::<Numbers>("target", "pose of the TCP: x y z (m) and w x y z, world")
    .also(&["target_prim"])
    .input_or(
        "position_tolerance",
        0.01,
        "there when nearer than this (m)",
    )
    .within(1.0e-4, 1.0)
    .input_or(
        "orientation_tolerance",
        0.05,
        "there when turned by less than this (rad)",
    )
    .within(1.0e-4, 3.2)
    .input_or(
        "use_target_orientation",
        true,
        "takes the target's orientation; otherwise straight down, turned by yaw",
    )
    .input_or(
        "yaw",
        0.0,
        "turn of the hand about the vertical axis (degrees)",
    )
    .within(-360.0, 360.0)
    .also(&["end_effector_yaw_degrees"]);
    watching(node_type)
}

/// With the ports about the cube that is watched, and about the way.
fn watching(node_type: NodeType<PyramidHost>) -> NodeType<PyramidHost> {
    node_type
        .input_or(
            "monitor_pickup_motion",
            false,
            "asks for a recovery when the cube moved, or is not reached in time",
        )
        .input_or(
            "monitor_grasp",
            false,
            "keeps the hand closed, and asks for a recovery when the cube left it",
        )
        .input_or("movement", 0.008, "a cube that moved further has moved (m)")
        .within(1.0e-4, 1.0)
        .also(&["movement_tolerance"])
        .input_or(
            "max_grasp_distance",
            0.05,
            "a cube further from the TCP is not in the hand (m); 0.14 from the \
         origin of the hand's own frame",
        )
        .within(1.0e-3, 1.0)
        .input_or(
            "warning_interval",
            5.0,
            "a warning is given each time the target was not reached for this long (s)",
        )
        .within(0.001, 3600.0)
        .input_or(
            "straight_lead",
            0.0,
            "goes in a straight line: the arm is led by a point so far ahead on it \
         (m); with 0 it is sent to the target at once, and bows",
        )
        .within(0.0, 1.0)
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

impl MoveToTarget {
    fn new(binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            target: binder.input("target")?,
            position_tolerance: binder.input("position_tolerance")?,
            orientation_tolerance: binder.input("orientation_tolerance")?,
            use_target_orientation: binder.input("use_target_orientation")?,
            yaw: binder.input("yaw")?,
            monitor_pickup_motion: binder.input("monitor_pickup_motion")?,
            monitor_grasp: binder.input("monitor_grasp")?,
            movement: binder.input("movement")?,
            max_grasp_distance: binder.input("max_grasp_distance")?,
            warning: binder.input("warning_interval")?,
            straight_lead: binder.input("straight_lead")?,
            skip_when_held: binder.input("skip_when_held")?,
            in_center: binder.input("in_center")?,
            watch: Watch::bind(binder)?,
        })
    }

    /// Whether the motion must not go on: a recovery was asked for.
    fn is_broken(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        if cx.get(&self.monitor_pickup_motion)? {
            let movement = cx.get(&self.movement)?;
            if self.watch.has_moved(cx, movement)? {
                return Ok(true);
            }
        }
        if cx.get(&self.monitor_grasp)? {
            let distance = cx.get(&self.max_grasp_distance)?;
            let counted = state.missed;
            if self.watch.is_lost(cx, distance, &mut state.missed)? {
                // Counted once, however long it lasts.
                cx.world.counters.drops += u32::from(counted < u32::MAX);
                state.missed = u32::MAX;
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn target(&self, cx: &Context<'_, '_>) -> Result<Pose, Fault> {
        let mut target = from_numbers(cx.get(&self.target)?);
        if !cx.get(&self.use_target_orientation)? {
            let yaw = cx.get(&self.yaw)?.to_radians();
            target.orientation_wxyz = geometry::straight_down(yaw);
        }
        Ok(target)
    }

    /// Where the arm is led to now on its way to `target`.
    fn led(&self, state: &mut State, cx: &Context<'_, '_>, target: Pose) -> Result<Pose, Fault> {
        let lead = cx.get(&self.straight_lead)?;
        let Some(tcp) = cx.world.tcp().filter(|_| lead > 0.0) else {
            return Ok(target);
        };
        let from = Vector3::from(*state.from.get_or_insert(tcp.position));
        let way = Vector3::from(target.position) - from;
        let length = way.norm();
        if length <= lead {
            return Ok(target);
        }
        let done = (Vector3::from(tcp.position) - from).dot(&way) / length;
        let ahead = (done.max(0.0) + lead).min(length);
        Ok(Pose {
            position: (from + way * (ahead / length)).into(),
            ..target
        })
    }

    fn warn(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        let name = cx.world.name();
        cx.world
            .out
            .log(format_args!("[warning] {name}: the target is not reached"));
        if cx.get(&self.monitor_pickup_motion)? {
            self.watch
                .recovery
                .request(cx, format_args!("the cube is not reached"))?;
        }
        Ok(())
    }
}

impl Leaf<PyramidHost> for MoveToTarget {
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
        if self.is_broken(state, cx)? {
            return Ok(Status::Running);
        }
        if cx.get(&self.in_center)? && !state.turn.comes(&self.watch.center, state.key, cx)? {
            state.alarm.clear();
            return Ok(Status::Running);
        }
        let target = self.target(cx)?;
        let gripper = if cx.get(&self.monitor_grasp)? {
            GripperGoal::Close
        } else {
            GripperGoal::Keep
        };
        let led = self.led(state, cx, target)?;
        cx.world.go(state.key, led, gripper);
        let position = cx.get(&self.position_tolerance)?;
        let orientation = cx.get(&self.orientation_tolerance)?;
        if cx
            .world
            .has_reached(state.key, &target, position, orientation)
        {
            return Ok(Status::Success);
        }
        if state.alarm.is_due(cx.now, cx.get(&self.warning)?) {
            self.warn(cx)?;
        }
        Ok(Status::Running)
    }
}
