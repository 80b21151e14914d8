//! One decision of a stacking policy: its questions about the cubes, and the record of failures
//! with them.

use std::ops::Range;

use ipc_types::decision::Outcome;
use ipc_types::world::OBJECT_DRAGGED;
use ipc_types::{GripperGoal, Text};
use nalgebra::Vector3;
use robocell_skills::geometry::plane_distance;
use robocell_skills::{Condition, World};
use robocell_task::job::Placement;
use robocell_task::{ArmIntent, Job, Observation, Output, TraceEvent};

use super::phase::{HOLD, Phase};
use super::setup::{ARM, STACK, StackSetup};
use crate::failure::Failure;

/// A cube below this height is off the table (m); the table's top is at 0.
const FALLEN_BELOW_M: f64 = -0.05;
/// Share of a layer by which a cube may be off its place and still carry the next: at half a
/// cube the next one topples.
const SEAT_SHARE: f64 = 0.4;

/// Name of the phase without a transfer when every cube is in its place.
const DONE: &str = "DONE";

/// The view of the arm in one decision, with the settings of the task. A cube is an index in
/// the order.
pub struct Turn<'w> {
    /// The settings.
    pub stack: &'w StackSetup,
    /// The cell.
    pub world: World<'w>,
    /// The phase of the command in this decision; `None` for a hold.
    pub phase: Option<Phase>,
}

impl<'w> Turn<'w> {
    /// `None` if the observation lacks the arm or a cube of the order; the policy then holds.
    pub fn new(
        stack: &'w StackSetup,
        observation: &'w Observation<'w>,
        job: &'w mut Job,
        out: &'w mut Output,
    ) -> Option<Self> {
        observation.arm(ARM)?;
        let mut cubes = stack.cubes.iter();
        let all = cubes.all(|cube| observation.object(*cube).is_some());
        all.then(|| Self {
            stack,
            world: World::new(&stack.skills, observation, job, out, ARM),
            phase: None,
        })
    }

    /// Index of a cube in the cell file; `usize::MAX`, which no object has, for a cube that is
    /// not in the order.
    pub fn object(&self, cube: usize) -> usize {
        self.stack.cubes.get(cube).copied().unwrap_or(usize::MAX)
    }

    /// Name of a cube.
    pub fn name(&self, cube: usize) -> &'w str {
        self.stack.skills.object_name(self.object(cube))
    }

    /// The pose of a cube in the stack.
    pub fn goal(&self, cube: usize) -> Placement {
        let goal = self.world.goal(self.object(cube), STACK, cube);
        goal.unwrap_or(NOWHERE)
    }

    /// Observed pose of a cube. A cube that is not in the cell any longer has [`Turn::fallen`].
    pub fn placement(&self, cube: usize) -> Placement {
        let seen = self.world.placement(self.object(cube));
        seen.unwrap_or(NOWHERE)
    }

    /// Centre of a cube (m).
    pub fn position(&self, cube: usize) -> Vector3<f64> {
        self.placement(cube).position.into()
    }

    /// All cubes, from bottom to top.
    pub fn cubes(&self) -> Range<usize> {
        0..self.stack.cubes.len()
    }

    /// The cubes other than `cube`.
    pub fn others(&self, cube: usize) -> impl Iterator<Item = usize> + use<> {
        self.cubes().filter(move |other| *other != cube)
    }

    /// Whether a cube is at its goal: in its own layer, and strictly nearer than the tolerance.
    pub fn at_goal(&self, cube: usize) -> bool {
        let tolerance = self.stack.spec.goal_tolerance_m;
        let slot = self.world.slot_of(self.object(cube), STACK, tolerance);
        slot == Some(cube)
    }

    /// Whether a cube is at its goal well enough to carry the next one.
    pub fn seated(&self, cube: usize) -> bool {
        let offset = plane_distance(self.position(cube), self.goal(cube).position.into());
        self.at_goal(cube) && offset < SEAT_SHARE * self.stack.spec.layer_height_m
    }

    /// Whether a cube that has to be in the gripper is not in it.
    pub fn dropped(&self, cube: usize) -> bool {
        let distance = self.stack.spec.drop_distance_m;
        self.world.has_left(self.object(cube), distance)
    }

    /// Whether a cube is off the table.
    pub fn fallen(&self, cube: usize) -> bool {
        let (object, below_m) = (self.object(cube), FALLEN_BELOW_M);
        Condition::Fallen { object, below_m }.holds(&self.world)
    }

    /// Whether the arm reaches a cube.
    pub fn reachable(&self, cube: usize) -> bool {
        Condition::Reachable(self.object(cube)).holds(&self.world)
    }

    /// Stops the arm. `gripper` opens after a drop; otherwise it keeps its state.
    pub fn hold(&mut self, gripper: GripperGoal) {
        self.phase = None;
        let intent = ArmIntent {
            gripper,
            ..ArmIntent::default()
        };
        self.world.out.arm(ARM, intent);
    }

    /// Records the loss of the held cube.
    pub fn note_drop(&mut self, cube: usize) {
        forget_held(self.world.job);
        self.world.note_drop(self.object(cube));
        self.count_failed_pick(cube, Failure::CubeCannotBeGripped, "was lost");
    }

    /// Records that a cube moved while it was picked up. A gripper that pushes a cube away on
    /// its way down would do so for ever, so that counts as a failed pick-up; an operator may
    /// drag the cube as often as they like.
    pub fn note_resync(&mut self, cube: usize, phase: Phase) {
        let object = self.object(cube);
        self.world.note_resync(object);
        let seen = self.world.observation.object(object);
        let dragged = seen.is_some_and(|seen| seen.flags & OBJECT_DRAGGED != 0);
        if phase == Phase::Approach && !dragged {
            let why = "moved when the gripper came";
            self.count_failed_pick(cube, Failure::CubeCannotBeGripped, why);
        }
    }

    /// Records the result of a set-down. A cube that does not stay in its place is tried again,
    /// but not for ever.
    pub fn note_placed(&mut self, cube: usize) {
        let object = self.object(cube);
        if self.seated(cube) {
            if let Some(attempts) = self.world.attempts_mut(object) {
                attempts.place = 0;
            }
            return;
        }
        // A cube at its goal that cannot carry the next one is not a failure.
        let most = if self.at_goal(cube) {
            u32::MAX
        } else {
            self.stack.spec.max_attempts
        };
        let reason = Failure::CubeCannotBePlaced.reason();
        let why = "does not stay in its place";
        self.world.count_failed_place(object, most, reason, why);
    }

    /// Records that the gripper does not open.
    pub fn note_blocked(&mut self, cube: usize) {
        let name = self.name(cube);
        self.world.fail(
            Failure::GripperBlocked.reason(),
            format_args!("the gripper does not open at {name}"),
        );
    }

    fn count_failed_pick(&mut self, cube: usize, failure: Failure, why: &str) {
        let most = self.stack.spec.max_attempts;
        let object = self.object(cube);
        self.world
            .count_failed_pick(object, most, failure.reason(), why);
    }

    /// Reports the state of the job: the phase, the outcome and the cubes in place.
    pub fn report(&mut self) {
        let done = self.world.job.done;
        self.world.out.phase = Text::new(match self.phase {
            Some(phase) => phase.name(),
            None if done => DONE,
            None => HOLD,
        });
        self.world.out.outcome = if done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        // Compared with the decision before, and only then updated: each loss is reported once.
        for cube in self.cubes() {
            let object = self.object(cube);
            let is_held = self.world.job.held == Some(object);
            if self.was_placed(object) && !is_held && !self.at_goal(cube) {
                self.note_displaced(cube);
            }
        }
        self.world.job.placed.clear();
        for cube in self.cubes() {
            let object = self.object(cube);
            if self.world.job.held != Some(object) && self.at_goal(cube) {
                let object = u32::try_from(object).unwrap_or(u32::MAX);
                self.world.job.placed.push(object);
            }
        }
    }

    /// Whether the decision before counted `object` as placed.
    fn was_placed(&self, object: usize) -> bool {
        let placed = self.world.job.placed.iter();
        placed
            .copied()
            .any(|known| usize::try_from(known) == Ok(object))
    }

    /// Reports a cube that left the stack without being held by the arm.
    fn note_displaced(&mut self, cube: usize) {
        self.world.job.counters.recoveries += 1;
        let name = self.name(cube);
        let line = format_args!("[recover] {name} is not in its place any more");
        self.world.out.event(TraceEvent::Recover, line);
    }
}

/// Placement of a cube that is not in the order; no caller passes one.
const NOWHERE: Placement = Placement {
    position: [0.0; 3],
    yaw: 0.0,
};

/// Removes the held object from the job: the gripper is empty.
pub fn forget_held(job: &mut Job) {
    job.held = None;
    job.destination = None;
    job.aborted = false;
}
