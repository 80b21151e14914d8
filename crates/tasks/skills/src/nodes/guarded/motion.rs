//! `MoveToTarget`: brings the TCP to a pose.

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use ipc_types::{GripperGoal, Pose};
use robocell_task::PolicyTime;
use serde::{Deserialize, Serialize};

use super::{Context, Guard, WorkKeys, guarded};
use crate::nodes::motions::tcp_pose;
use crate::nodes::{ARM, poses};
use crate::progress::Step;
use crate::setup::Setup;
use crate::shared::{Alarm, Turn};
use crate::skill::Station;
use crate::world::Drive;

/// See the module.
struct MoveToTarget {
    target: In<[f64; 7]>,
    position_tolerance: In<f64>,
    orientation_tolerance: In<f64>,
    use_target_orientation: In<bool>,
    yaw: In<f64>,
    monitor_pickup_motion: In<bool>,
    monitor_grasp: In<bool>,
    max_grasp_distance: In<f64>,
    warning: In<f64>,
    straight_lead: In<f64>,
    guard: Guard,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    step: Step,
    alarm: Alarm,
    missed: u32,
    turn: Turn,
}

/// The node type.
pub(super) fn node_type(keys: WorkKeys) -> NodeType<Station> {
    let node_type = NodeType::new(
        "MoveToTarget",
        "Moves the TCP to a target. It may watch the object it approaches, or the \
         one it carries, and asks for a recovery when that one moved.",
        move |binder| MoveToTarget::new(binder, keys),
    )
    .aliases(&["FrankaMoveToTarget"])
    .keywords(&["motion", "reach", "pose", "go"])
    .drives(ARM)
    .input::<[f64; 7]>("target", "pose of the TCP: x y z (m) and w x y z, world")
    .also(&["target_prim"])
    .input_or(
        "position_tolerance",
        0.01,
        "reached when nearer than this (m)",
    )
    .within(1.0e-4, 1.0)
    .input_or(
        "orientation_tolerance",
        0.05,
        "reached when turned by less than this (rad)",
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
        "turn of the tool about the vertical axis (degrees)",
    )
    .within(-360.0, 360.0)
    .also(&["end_effector_yaw_degrees"]);
    guarded(watching(node_type))
}

/// Adds the ports about the watched object and about the path.
fn watching(node_type: NodeType<Station>) -> NodeType<Station> {
    node_type
        .input_or(
            "monitor_pickup_motion",
            false,
            "asks for a recovery when the object moved, or is not reached in time",
        )
        .input_or(
            "monitor_grasp",
            false,
            "keeps the gripper closed, and asks for a recovery when the object is lost, or the \
             target is not reached in time",
        )
        .input_or(
            "max_grasp_distance",
            0.05,
            "an object further from the TCP is not in the gripper (m)",
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
            "moves in a straight line: the arm follows a point this far ahead of it on \
             the line (m); with 0 it is sent to the target at once",
        )
        .within(0.0, 1.0)
}

impl MoveToTarget {
    fn new(binder: &mut Binder<'_>, keys: WorkKeys) -> Result<Self, BindError> {
        let target = binder.input::<[f64; 7]>("target")?;
        if let In::Literal(numbers) = target {
            poses::check(binder, &Setup::unknown(), "target", &numbers);
        }
        Ok(Self {
            target,
            position_tolerance: binder.input("position_tolerance")?,
            orientation_tolerance: binder.input("orientation_tolerance")?,
            use_target_orientation: binder.input("use_target_orientation")?,
            yaw: binder.input("yaw")?,
            monitor_pickup_motion: binder.input("monitor_pickup_motion")?,
            monitor_grasp: binder.input("monitor_grasp")?,
            max_grasp_distance: binder.input("max_grasp_distance")?,
            warning: binder.input("warning_interval")?,
            straight_lead: binder.input("straight_lead")?,
            guard: Guard::bind(binder, keys)?,
        })
    }

    /// Whether the motion must stop: a recovery was requested.
    // The pick-up is checked first: a cube that moved before the grip was never held.
    fn is_broken(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<bool, Fault> {
        if cx.get(&self.monitor_pickup_motion)? && self.guard.has_moved(cx)? {
            return Ok(true);
        }
        let distance = cx.get(&self.max_grasp_distance)?;
        Ok(cx.get(&self.monitor_grasp)? && self.guard.is_lost(cx, distance, &mut state.missed)?)
    }

    fn drive(&self, cx: &Context<'_, '_>) -> Result<Drive, Fault> {
        let mut target = Pose::IDENTITY;
        if let Some(pose) = tcp_pose(&cx.get(&self.target)?, cx.world) {
            target = pose;
        }
        if !cx.get(&self.use_target_orientation)? {
            let yaw = cx.get(&self.yaw)?.to_radians();
            target.orientation_wxyz = cx.world.tool().down(yaw);
        }
        // Closed in every command while an object is carried: the goal before may have been
        // another.
        let gripper = if cx.get(&self.monitor_grasp)? {
            GripperGoal::Close
        } else {
            GripperGoal::Keep
        };
        Ok(Drive {
            tolerance_m: cx.get(&self.position_tolerance)?,
            angle_rad: cx.get(&self.orientation_tolerance)?,
            settle: PolicyTime::from_ticks(0),
            lead_m: cx.get(&self.straight_lead)?,
            ..Drive::travel(target, gripper)
        })
    }

    fn warn(&self, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        let name = cx.world.arm_name();
        let out = &mut *cx.world.out;
        out.log(format_args!("[warning] {name}: the target is not reached"));
        if cx.get(&self.monitor_pickup_motion)? {
            let recovery = &self.guard.recovery;
            recovery.request(cx, format_args!("the object is not reached"))?;
        } else if cx.get(&self.monitor_grasp)? {
            // Something is in the way of the object: another place may be free.
            let recovery = &self.guard.recovery;
            recovery.request(cx, format_args!("the place is not reached"))?;
        }
        Ok(())
    }
}

impl Leaf<Station> for MoveToTarget {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = State::default();
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        if self.guard.skips(cx)? {
            return Ok(Status::Success);
        }
        if self.is_broken(state, cx)? {
            // The arm holds until the recovery branch commands it.
            cx.world.hold();
            return Ok(Status::Running);
        }
        if !self.guard.may_work(&mut state.turn, cx)? {
            // Waiting for the zone does not delay the motion.
            state.alarm.clear();
            return Ok(Status::Running);
        }
        if cx.world.resumed {
            // The time without decisions does not count as time of the motion.
            state.alarm.clear();
        }
        let drive = self.drive(cx)?;
        if cx.world.drive(&mut state.step, &drive) {
            return Ok(Status::Success);
        }
        if state.alarm.is_due(cx.now, cx.get(&self.warning)?) {
            self.warn(cx)?;
        }
        Ok(Status::Running)
    }
}
