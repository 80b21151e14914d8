//! `RecoverCube`: goes above the arm's cube and waits until it lies still.

use robocell_task::TraceEvent;
use std::sync::Arc;
use std::time::Duration;

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use ipc_types::GripperGoal;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Alarm, Turn, seconds};
use crate::pyramid::center::Center;
use crate::pyramid::cubes::{self, CubeState, Cubes};
use crate::pyramid::grip;
use crate::pyramid::host::{Context, PyramidHost};
use crate::pyramid::keys::Recovery;
use crate::pyramid::setup::PyramidSetup;
use crate::pyramid::targets::{self, Targets, goal_of};

/// An arm that cannot reach its cube waits at this share of its reach.
const WAITING_SHARE: f64 = 0.85;

/// See the module.
struct RecoverCube {
    movement: In<f64>,
    staging_height: In<f64>,
    position_tolerance: In<f64>,
    stable_time: In<f64>,
    warning: In<f64>,
    yaw: In<f64>,
    cubes: Cubes,
    center: Center,
    recovery: Recovery,
    targets: Targets,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    key: u64,
    turn: Turn,
    /// Another arm's cube the hand opens around.
    let_go: Option<usize>,
    /// Where the cube was when it moved last (m), and since when it is there.
    reference: Option<[f64; 3]>,
    still_since: Duration,
    alarm: Alarm,
}

/// No turn that a file may name: that of the arm.
const OWN_YAW: f64 = 1.0e6;

/// The node type.
pub(in crate::pyramid) fn node_type(setup: &Arc<PyramidSetup>) -> NodeType<PyramidHost> {
    let setup = Arc::clone(setup);
    NodeType::new(
        "RecoverCube",
        "Takes the centre, opens the hand, goes above the arm's cube and waits \
         there until it lies still. Fails when it is through, so that a selector \
         goes on with the pick-up, and at once when a cube is in the hand; one \
         that another arm works at is let go first.",
        move |binder| RecoverCube::new(&setup, binder),
    )
    .aliases(&["FrankaRecoverCube"])
    .keywords(&["retry", "restage", "drop", "disturbance"])
    .input_or(
        "movement",
        0.008,
        "a cube that moved by more than half of this is not still (m)",
    )
    .within(1.0e-4, 1.0)
    .also(&["movement_tolerance"])
    .input_or("staging_height", 0.20, "TCP above the cube's centre (m)")
    .within(0.0, 1.0)
    .input_or(
        "position_tolerance",
        0.025,
        "there when nearer than this (m)",
    )
    .within(1.0e-4, 1.0)
    .input_or("stable_time", 0.20, "time the cube has to lie still (s)")
    .within(0.0, 60.0)
    .also(&["stable_duration"])
    .input_or(
        "warning_interval",
        5.0,
        "a warning is given each time the cube was out of reach for this long (s)",
    )
    .input_or(
        "yaw",
        OWN_YAW,
        "turn of the hand about the vertical axis (degrees); the arm's own without",
    )
    .within(-360.0, 360.0)
    .also(&["end_effector_yaw_degrees"])
}

impl RecoverCube {
    fn new(setup: &PyramidSetup, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            movement: binder.input("movement")?,
            staging_height: binder.input("staging_height")?,
            position_tolerance: binder.input("position_tolerance")?,
            stable_time: binder.input("stable_time")?,
            warning: binder.input("warning_interval")?,
            yaw: binder.input("yaw")?,
            cubes: Cubes::bind(setup, binder)?,
            center: Center::bind(binder)?,
            recovery: Recovery::bind(binder)?,
            targets: Targets::bind(binder)?,
        })
    }

    /// Aims at the cube anew; `false` where it is not seen.
    fn aim(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<bool, Fault> {
        let stack = self.cubes.placed(cx)?;
        match cx.world.arm_setup() {
            Some(arm) => {
                let goal = goal_of(cx.world, arm, stack, cube);
                self.targets.aim(cx, cube, goal)
            }
            None => Ok(false),
        }
    }

    /// Goes above `position`, or as near to it as is wise; whether it is there.
    fn stage(
        &self,
        state: &State,
        cx: &mut Context<'_, '_>,
        position: Vector3<f64>,
    ) -> Result<bool, Fault> {
        let Some(arm) = cx.world.arm_setup() else {
            return Ok(false);
        };
        let height = cx.get(&self.staging_height)?;
        let reachable = cubes::is_reachable(cx.world, position);
        let mut staging = position + Vector3::z() * height;
        if !reachable {
            let reach = WAITING_SHARE * cx.world.setup.numbers.reach_m;
            let outward = position.xy() - arm.base;
            let near = arm.base + outward * (reach / outward.norm());
            // A cube that fell off the table is waited for above the table.
            let low = cx.world.setup.numbers.base_height_m;
            staging = Vector3::new(near.x, near.y, position.z.max(low) + height);
        }
        let yaw = match cx.get(&self.yaw)? {
            OWN_YAW => arm.yaw,
            degrees => degrees.to_radians(),
        };
        cx.world
            .go(state.key, targets::down(staging, yaw), GripperGoal::Open);
        let tolerance = cx.get(&self.position_tolerance)?;
        let error = cx.world.tcp().map_or(f64::INFINITY, |t| {
            (Vector3::from(t.position) - staging).norm()
        });
        Ok(reachable && error <= tolerance)
    }

    fn is_still(
        &self,
        state: &mut State,
        cx: &Context<'_, '_>,
        position: Vector3<f64>,
    ) -> Result<bool, Fault> {
        let tolerance = 0.5 * cx.get(&self.movement)?;
        let moved = state
            .reference
            .is_none_or(|reference| (position - Vector3::from(reference)).norm() > tolerance);
        if moved {
            state.reference = Some(position.into());
            state.still_since = cx.now;
        }
        let still = cx.now.saturating_sub(state.still_since);
        Ok(still >= seconds(cx.get(&self.stable_time)?))
    }

    fn warn(&self, cx: &mut Context<'_, '_>, cube: usize, position: Vector3<f64>) {
        let (arm, name) = (self.cubes.me(), cx.world.setup.cube_name(cube));
        let why = if cubes::is_reachable(cx.world, position) {
            "is not reached"
        } else {
            "is out of reach"
        };
        cx.world.out.log(format_args!(
            "[warning] {arm}: {name} {why}, waiting for it"
        ));
    }

    /// Opens the hand where it is: what falls must not lie on the arm's cube.
    fn let_go(&self, state: &mut State, cx: &mut Context<'_, '_>, held: usize) {
        cx.world.grip(GripperGoal::Open);
        if state.let_go.replace(held) != Some(held) {
            let (arm, name) = (self.cubes.me(), cx.world.setup.cube_name(held));
            cx.world.out.event(
                TraceEvent::Recover,
                format_args!("[recover] {arm}: lets {name} go, it is another arm's"),
            );
        }
    }

    /// The end of a recovery. A cube that the fingers do not get around is left
    /// to itself: perhaps another one has to be taken first.
    fn finish(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<Status, Fault> {
        let arm = cx.world.arm_setup();
        let crowded = arm.is_some_and(|arm| !grip::is_free(cx.world, arm, cube));
        if crowded || !cubes::is_free_on_top(cx.world, cube) {
            self.cubes.set_state(cx, cube, CubeState::Available)?;
            self.cubes.set_current(cx, None)?;
        }
        self.recovery.clear(cx)?;
        Ok(Status::Failure)
    }
}

impl Leaf<PyramidHost> for RecoverCube {
    type State = State;

    fn start(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = State {
            key: cx.world.new_key(),
            ..State::default()
        };
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let interval = cx.get(&self.warning)?;
        if interval <= 0.0 {
            let arm = self.cubes.me();
            cx.world.out.event(
                TraceEvent::Fault,
                format_args!(
                    "[error] {arm}: a warning interval of {interval} s; a positive one is needed"
                ),
            );
            return Ok(Status::Failure);
        }
        let held = cx.world.cube_in_hand();
        if let Some(held) = held
            && self.cubes.state(cx, held)? == CubeState::Others
        {
            self.let_go(state, cx, held);
            return Ok(Status::Running);
        }
        let (None, Some(cube)) = (held, self.cubes.current(cx)?) else {
            // Nothing to look after; or what is in the hand is taken from here
            // by the pick-up.
            self.recovery.clear(cx)?;
            return Ok(Status::Failure);
        };
        if !state.turn.comes(&self.center, state.key, cx)? {
            return Ok(Status::Running);
        }
        self.cubes.set_state(cx, cube, CubeState::Reserved)?;
        let seen = cx.world.cube_position(cube);
        let Some(position) = seen.filter(|p| p.iter().all(|x| x.is_finite())) else {
            cx.world.grip(GripperGoal::Open);
            return Ok(Status::Running);
        };
        self.aim(cx, cube)?;
        let still = self.is_still(state, cx, position)?;
        let there = self.stage(state, cx, position)?;
        if there {
            state.alarm.clear();
        } else if state.alarm.is_due(cx.now, interval) {
            self.warn(cx, cube, position);
        }
        if there && still {
            return self.finish(cx, cube);
        }
        Ok(Status::Running)
    }
}
