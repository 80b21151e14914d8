//! The definition of a job, and the inputs of its functions.

use behavior::matrix::Next;
use behavior::numbers::Numbers;
use ipc_types::world::{OBJECT_DRAGGED, OBJECT_ENABLED};
use ipc_types::{GripperState, Pose};
use nalgebra::{Isometry3, Vector3};
use robocell_task::{Observation, PolicyTime, TraceEvent};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::arm::{ArmMemory, ArmNumbers};
use crate::named::Named;
use crate::path::{Paces, Reached, Route};
use crate::pose;
use crate::suction::{GripChange, break_cause, break_limit};
use crate::world::World;

/// A condition that makes an event pending.
pub type Pending<J> = fn(&Turn<'_, J>) -> bool;
/// A function that a cell of the matrix calls.
pub type Handler<J> = fn(&mut Turn<'_, J>) -> Next;

/// A job of one arm whose decisions are a matrix in a file. The file may name the events,
/// states and handlers of this trait, and no others.
pub trait MatrixJob: Send + Sized + 'static {
    /// The states.
    type State: Named + PartialEq;
    /// Its memory beside that of the matrix and the arm; part of the checkpoint.
    type Memory: Default + Serialize + DeserializeOwned + Send;
    /// Its own numbers in the behaviour file.
    type Numbers: Send;

    /// The events by name, each with its condition.
    const EVENTS: &'static [(&'static str, Pending<Self>)];
    /// The handlers, by name.
    const HANDLERS: &'static [(&'static str, Handler<Self>)];

    /// Reads its own numbers.
    fn numbers(from: &mut Numbers) -> Self::Numbers;

    /// The paces of its motions.
    fn paces(&self, own: &Self::Numbers) -> Paces;

    /// Whether a memory from a checkpoint is valid.
    fn is_sound(&self, _memory: &Self::Memory) -> bool {
        true
    }

    /// Changes the new memory after the task was reset.
    fn reset(_memory: &mut Self::Memory) {}

    /// Called before the conditions of the events.
    fn observe(_turn: &mut Turn<'_, Self>) {}

    /// Called after the event was handled: sets requests to the equipment, the outcome of the
    /// job, and the objects in place.
    fn report(turn: &mut Turn<'_, Self>);

    /// See [`robocell_task::AnyPolicy::default_pose`].
    fn default_pose(&self) -> Option<Pose> {
        None
    }

    /// Resumes from the observation after missed decisions, where the memory does not fit it;
    /// returns the state to continue in.
    fn reconcile(turn: &mut Turn<'_, Self>) -> Next;

    /// See [`robocell_task::Policy::tend`]. The memory is a new one, and commands to the arm
    /// and the log are dropped.
    fn tend(_turn: &mut Turn<'_, Self>) {}
}

/// One decision of a job.
pub struct Turn<'t, J: MatrixJob> {
    /// The job.
    pub of: &'t J,
    /// The numbers of the job in the behaviour file.
    pub own: &'t J::Numbers,
    /// The numbers about the arm.
    pub numbers: &'t ArmNumbers,
    /// The observation, and the output for goals and the log.
    pub world: World<'t>,
    /// The memory of the arm.
    pub arm: &'t mut ArmMemory,
    /// The memory of the job.
    pub memory: &'t mut J::Memory,
    /// The state at the start of the decision.
    pub state: J::State,
    /// Policy time.
    pub now: PolicyTime,
    /// Measured TCP, world frame.
    pub tcp: Pose,
    /// Measured gripper.
    pub gripper: &'t GripperState,
    /// The change of the grip since the last decision.
    pub grip: GripChange,
    /// Progress on the path in this decision.
    pub reached: Reached,
}

/// An observed object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its pose, world frame.
    pub pose: Isometry3<f64>,
    /// Whether it does not move and the operator does not drag it.
    pub at_rest: bool,
}

impl Seen {
    /// An object; `None` if it is not in the cell.
    pub fn of(numbers: &ArmNumbers, seen: &Observation<'_>, object: usize) -> Option<Self> {
        let seen = seen.object(object)?;
        let slower = |v: [f64; 3], limit| Vector3::from(v).norm() < limit;
        (seen.flags & OBJECT_ENABLED != 0).then(|| Self {
            pose: pose::isometry(&seen.pose),
            at_rest: slower(seen.twist.linear, numbers.rest_speed_m_s)
                && slower(seen.twist.angular, numbers.rest_turn_rad_s)
                && seen.flags & OBJECT_DRAGGED == 0,
        })
    }
}

impl<'t, J: MatrixJob> Turn<'t, J> {
    /// An object; `None` if it is not in the cell.
    pub fn seen(&self, object: usize) -> Option<Seen> {
        Seen::of(self.numbers, self.world.observation, object)
    }

    /// The object on the cup.
    pub fn held(&self) -> Option<usize> {
        let attached = self.gripper.attached == 1;
        self.world.held().filter(|_| attached)
    }

    /// Name of an object, for the log.
    pub fn name(&self, object: usize) -> &'t str {
        self.world.setup.object_name(object)
    }

    /// A new path, which starts at the TCP.
    pub fn route(&mut self) -> Route<'_> {
        // A pause for the goal before does not delay the new one.
        self.arm.wait_until = self.now;
        let paces = self.of.paces(self.own);
        Route::new(&mut self.arm.path, paces, self.tcp, self.now)
    }

    /// Whether the arm is on its path, as if no decision had been missed; `None` if it has no
    /// path.
    pub fn is_on_path(&self) -> Option<bool> {
        let within = self.numbers.resume_m;
        self.arm.path.is_near(&self.tcp, within, self.now)
    }

    /// Whether the state has lasted longer than `limit`.
    pub fn is_late(&self, limit: PolicyTime) -> bool {
        self.now.since(self.arm.since) > limit
    }

    /// Counts a failed pick-up of an object. After `most` in a row the job fails with `reason`;
    /// `what` is what happened to it. Returns whether it failed.
    pub fn count_failed_pick(
        &mut self,
        object: usize,
        most: u32,
        reason: &str,
        what: &str,
    ) -> bool {
        let attempts = self.world.attempts_mut(object);
        let failed = attempts.is_some_and(|attempts| {
            attempts.pick += 1;
            attempts.pick >= most
        });
        if failed {
            let name = self.name(object);
            let why = format_args!("{name} {what} again and again");
            self.world.fail(reason, why);
        }
        failed
    }

    /// Reports that an object is no longer attached, and why its grip broke. `counts` adds it
    /// to the drops.
    pub fn note_drop(&mut self, object: usize, counts: bool) {
        self.world.job.counters.drops += u32::from(counts);
        let (name, gripper) = (self.name(object), self.gripper);
        let out = &mut *self.world.out;
        // Without a break there is no limit and no cause to name.
        if !self.grip.broken {
            let why = format_args!("[drop] {name} is not attached any more");
            return out.event(TraceEvent::Drop, why);
        }
        let (limit, cause) = (break_limit(gripper), break_cause(gripper));
        let (force, torque) = (gripper.peak_force, gripper.peak_torque);
        out.event(
            TraceEvent::GripBroke,
            format_args!(
                "[break] {name}: {limit} limit, by {cause} (peak {force:.1} N, {torque:.2} N m)"
            ),
        );
    }
}

/// Conditions that are the same for every job.
pub mod when {
    use super::{MatrixJob, Reached, Turn};

    /// The last waypoint was reached.
    pub fn goal_reached<J: MatrixJob>(turn: &Turn<'_, J>) -> bool {
        turn.reached == Reached::Goal
    }

    /// A waypoint that is not the last was reached.
    pub fn waypoint_reached<J: MatrixJob>(turn: &Turn<'_, J>) -> bool {
        turn.reached == Reached::Waypoint
    }

    /// Never: the event exists for files that name it.
    pub fn never<J: MatrixJob>(_turn: &Turn<'_, J>) -> bool {
        false
    }
}
