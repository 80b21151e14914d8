//! `RecoverCube`: moves above the arm's cube and waits until it is at rest.

use std::sync::Arc;
use std::time::Duration;

use behavior::Status;
use behavior::board::{Fault, In};
use behavior::tree::{BindError, Binder, Leaf, NodeType};
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;
use robocell_skills::nodes::Context;
use robocell_skills::progress::Step;
use robocell_skills::shared::{Alarm, Turn, has_lasted};
use robocell_skills::world::Drive;
use robocell_skills::{Owner, Station};
use robocell_task::{PolicyTime, TraceEvent};
use serde::{Deserialize, Serialize};

use crate::pyramid::notes::Notes;
use crate::pyramid::setup::Pyramid;

/// In place of this warning, and of this recovery in a row, the cube is available to all arms
/// again.
// A person may move the cube a few times; an arm that tries longer keeps the centre from the other.
const WARNINGS: u32 = 3;
const RECOVERIES: i64 = 5;
/// A cube nearer to the TCP than this may still be in the gripper (m).
const IN_GRIPPER_M: f64 = 0.03;
/// Outside of the range that a file may name: the arm's own turn is used.
const OWN_YAW: f64 = 1.0e6;

/// See the module.
struct RecoverCube {
    movement: In<f64>,
    staging_height: In<f64>,
    position_tolerance: In<f64>,
    stable_time: In<f64>,
    warning: In<f64>,
    yaw: In<f64>,
    notes: Notes,
}

#[derive(Default, Serialize, Deserialize)]
struct State {
    step: Step,
    turn: Turn,
    /// A cube of another arm around which the gripper opens.
    let_go: Option<usize>,
    /// Position of the cube at its last motion (m), and the time since which it has been there.
    reference: Option<[f64; 3]>,
    still_since: Duration,
    alarm: Alarm,
    /// Warnings so far.
    warnings: u32,
    /// Decisions in a row without the cube in the gripper.
    missed: u32,
}

/// The node type.
pub(super) fn node_type(job: &Arc<Pyramid>) -> NodeType<Station> {
    let about = (
        "RecoverCube",
        "Takes the centre, opens the gripper, moves above the arm's cube and waits \
         there until it is at rest. Fails when that is done, so that a selector \
         continues with the pick-up, and at once when a cube is in the gripper or the \
         arm's cube is out of reach, which is available again then; a cube that \
         another arm works at is released first.",
    );
    super::node_type(about, job, RecoverCube::new)
        .aliases(&["FrankaRecoverCube"])
        .keywords(&["retry", "restage", "drop", "disturbance"])
        .input_or(
            "movement",
            0.008,
            "a cube that moved by more than half of this is not at rest (m)",
        )
        .within(1.0e-4, 1.0)
        .also(&["movement_tolerance"])
        .input_or("staging_height", 0.20, "TCP above the cube's centre (m)")
        .within(0.0, 1.0)
        .input_or(
            "position_tolerance",
            0.025,
            "reached when nearer than this (m)",
        )
        .within(1.0e-4, 1.0)
        .input_or("stable_time", 0.20, "time the cube has to be at rest (s)")
        .within(0.0, 60.0)
        .also(&["stable_duration"])
        .input_or(
            "warning_interval",
            5.0,
            "a warning is given each time the cube was not reached for this long (s); in place \
             of the third one the cube is available again",
        )
        .input_or(
            "yaw",
            OWN_YAW,
            "turn of the tool about the vertical axis (degrees); the arm's own without",
        )
        .within(-360.0, 360.0)
        .also(&["end_effector_yaw_degrees"])
}

impl RecoverCube {
    fn new(notes: Notes, binder: &mut Binder<'_>) -> Result<Self, BindError> {
        Ok(Self {
            movement: binder.input("movement")?,
            staging_height: binder.input("staging_height")?,
            position_tolerance: binder.input("position_tolerance")?,
            stable_time: binder.input("stable_time")?,
            warning: binder.input("warning_interval")?,
            yaw: binder.input("yaw")?,
            notes,
        })
    }

    /// Moves above `position`; returns whether it is there.
    fn stage(
        &self,
        state: &mut State,
        cx: &mut Context<'_, '_>,
        cube: usize,
        position: Vector3<f64>,
    ) -> Result<bool, Fault> {
        let (Some(arm), Some(own)) = (cx.world.arm_setup(), self.notes.look(cx).goal(cube, 0))
        else {
            return Ok(false);
        };
        let mut staging = position;
        staging.z += cx.get(&self.staging_height)?;
        let yaw = match cx.get(&self.yaw)? {
            OWN_YAW => own.yaw,
            degrees => degrees.to_radians(),
        };
        let target = Pose {
            position: staging.into(),
            orientation_wxyz: arm.tool.down(yaw),
        };
        let drive = Drive {
            tolerance_m: cx.get(&self.position_tolerance)?,
            angle_rad: f64::INFINITY,
            settle: PolicyTime::from_ticks(0),
            ..Drive::travel(target, GripperGoal::Open)
        };
        Ok(cx.world.drive(&mut state.step, &drive))
    }

    fn is_at_rest(
        &self,
        state: &mut State,
        cx: &Context<'_, '_>,
        position: Vector3<f64>,
    ) -> Result<bool, Fault> {
        let tolerance = 0.5 * cx.get(&self.movement)?;
        let moved = state
            .reference
            .is_none_or(|reference| (position - Vector3::from(reference)).norm() > tolerance);
        // The reference is replaced only after a motion, so a cube that creeps slowly is not at
        // rest either.
        if moved {
            state.reference = Some(position.into());
            state.still_since = cx.now;
        }
        Ok(has_lasted(
            state.still_since,
            cx.now,
            cx.get(&self.stable_time)?,
        ))
    }

    fn warn(&self, cx: &mut Context<'_, '_>, cube: usize) {
        let (arm, name) = (self.notes.me, cx.world.setup.object_name(cube));
        let out = &mut *cx.world.out;
        out.log(format_args!(
            "[warning] {arm}: {name} is not reached, waiting for it"
        ));
    }

    /// Makes a cube that the arm cannot take available: another arm may reach it, and this
    /// arm takes another cube meanwhile. `AcquireCube` gives the zone back if there is none.
    fn give_up(&self, cx: &mut Context<'_, '_>, cube: usize, why: &str) -> Result<Status, Fault> {
        let (arm, name) = (self.notes.me, cx.world.setup.object_name(cube));
        let why = format_args!("[recover] {arm}: {name} {why}, and available again");
        cx.world.out.event(TraceEvent::Recover, why);
        self.notes.give_up(cx, cube)?;
        self.notes.recovery.clear(cx)?;
        Ok(Status::Failure)
    }

    /// Opens the gripper in place: the cube must not fall on the arm's own one.
    fn let_go(&self, state: &mut State, cx: &mut Context<'_, '_>, held: usize) {
        cx.world.stay(GripperGoal::Open);
        if state.let_go.replace(held) != Some(held) {
            let (arm, name) = (self.notes.me, cx.world.setup.object_name(held));
            let why = format_args!("[recover] {arm}: releases {name}, another arm works at it");
            cx.world.out.event(TraceEvent::Recover, why);
        }
    }

    /// The end of a recovery. A cube without room for the fingers is made available again:
    /// another one may have to be picked first.
    fn finish(&self, cx: &mut Context<'_, '_>, cube: usize) -> Result<Status, Fault> {
        if self.notes.count_recovery(cx)? >= RECOVERIES {
            return self.give_up(cx, cube, "is not gripped");
        }
        let look = self.notes.look(cx);
        if !look.is_free_around(cube) || cx.world.is_covered(cube) {
            self.notes.set_owner(cx, cube, Owner::Available)?;
            self.notes.set_current(cx, None)?;
        }
        self.notes.recovery.clear(cx)?;
        // Failure on purpose: the selector above then continues with the pick-up.
        Ok(Status::Failure)
    }

    /// Moves above the cube in the zone, and ends when it is at rest there or is not reached.
    fn follow(
        &self,
        state: &mut State,
        cx: &mut Context<'_, '_>,
        (cube, position): (usize, Vector3<f64>),
        interval: f64,
    ) -> Result<Status, Fault> {
        if !state.turn.comes(&self.notes.zone, cx)? {
            return Ok(Status::Running);
        }
        // Reserved again, also from `carried`: the cube has left the gripper.
        self.notes.set_owner(cx, cube, Owner::Reserved)?;
        let stack = self.notes.stack(cx)?;
        // The targets follow the cube in each tick, so the pick-up starts from its present
        // pose.
        self.notes.aim(cx, cube, stack)?;
        let at_rest = self.is_at_rest(state, cx, position)?;
        let there = self.stage(state, cx, cube, position)?;
        // The interval counts only while the arm is not there: a cube that settles slowly is
        // not a fault.
        if there {
            state.alarm.clear();
        } else {
            let name = cx.world.setup.object_name(cube);
            let since = state.step.began;
            cx.world
                .note_wait(since, format_args!("{name} is not reached"));
        }
        if !there && state.alarm.is_due(cx.now, interval) {
            state.warnings += 1;
            if state.warnings >= WARNINGS {
                return self.give_up(cx, cube, "is not reached");
            }
            self.warn(cx, cube);
        }
        if there && at_rest {
            return self.finish(cx, cube);
        }
        Ok(Status::Running)
    }
}

/// Whether a closed gripper is still around the cube, whose contacts are missing for a moment:
/// fingers that open in the air would drop it.
fn may_be_held(state: &mut State, cx: &Context<'_, '_>, cube: usize) -> bool {
    let away = cx.world.has_left(cube, IN_GRIPPER_M) || cx.world.is_open();
    !away && !cx.world.is_lost(cube, &mut state.missed)
}

impl Leaf<Station> for RecoverCube {
    type State = State;

    fn start(&self, state: &mut State, _cx: &mut Context<'_, '_>) -> Result<(), Fault> {
        *state = State::default();
        Ok(())
    }

    fn tick(&self, state: &mut State, cx: &mut Context<'_, '_>) -> Result<Status, Fault> {
        let interval = cx.get(&self.warning)?;
        // A warning that is always due would fill the log; the file names the interval, so it
        // can be wrong.
        if interval <= 0.0 {
            let arm = self.notes.me;
            let why = format_args!(
                "[error] {arm}: a warning interval of {interval} s; a positive one is needed"
            );
            cx.world.out.event(TraceEvent::Fault, why);
            return Ok(Status::Failure);
        }
        if let Some(held) = self.notes.held_of_another(cx)? {
            self.let_go(state, cx, held);
            return Ok(Status::Running);
        }
        let (None, Some(cube)) = (cx.world.held(), self.notes.current(cx)?) else {
            // No cube to recover, or the pick-up continues with the one in the gripper.
            self.notes.recovery.clear(cx)?;
            return Ok(Status::Failure);
        };
        if may_be_held(state, cx, cube) {
            cx.world.stay(GripperGoal::Close);
            return Ok(Status::Running);
        }
        let Some(position) = cx.world.position(cube) else {
            return self.give_up(cx, cube, "is not in the cell");
        };
        if !self.notes.look(cx).reaches(position) {
            return self.give_up(cx, cube, "is out of reach");
        }
        self.follow(state, cx, (cube, position), interval)
    }
}
