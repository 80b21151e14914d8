//! What a job gives, and what its functions work with.

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
/// What a cell of the matrix calls.
pub type Handler<J> = fn(&mut Turn<'_, J>) -> Next;

/// A job of one arm whose decisions are a matrix in a file. The file may name the
/// events, states and handlers given here, and no others.
pub trait MatrixJob: Send + Sized + 'static {
    /// The states.
    type State: Named + PartialEq;
    /// What it remembers beside the matrix and the arm; part of the checkpoint.
    type Memory: Default + Serialize + DeserializeOwned + Send;
    /// The numbers of its own in the behaviour file.
    type Numbers: Send;

    /// The events, by name: when each is pending.
    const EVENTS: &'static [(&'static str, Pending<Self>)];
    /// The handlers, by name.
    const HANDLERS: &'static [(&'static str, Handler<Self>)];

    /// Reads the numbers of its own.
    fn numbers(from: &mut Numbers) -> Self::Numbers;

    /// The paces of its ways.
    fn paces(&self, own: &Self::Numbers) -> Paces;

    /// Whether a memory out of a checkpoint can be worked with.
    fn is_sound(&self, _memory: &Self::Memory) -> bool {
        true
    }

    /// Changes a new memory after the task was reset.
    fn reset(_memory: &mut Self::Memory) {}

    /// Before events are looked for.
    fn observe(_turn: &mut Turn<'_, Self>) {}

    /// After the event was handled: equipment, whether the job is done, and which
    /// objects are in place.
    fn report(turn: &mut Turn<'_, Self>);

    /// See [`robocell_task::AnyPolicy::default_pose`].
    fn default_pose(&self) -> Option<Pose> {
        None
    }

    /// Continues from what is seen after missed decisions, where the memory does
    /// not fit; answers the state to continue in.
    fn reconcile(turn: &mut Turn<'_, Self>) -> Next;

    /// See [`robocell_task::Policy::tend`]. The memory is a new one, and what is said
    /// to the arm and the log is not heard.
    fn tend(_turn: &mut Turn<'_, Self>) {}
}

/// One decision of a job.
pub struct Turn<'t, J: MatrixJob> {
    /// The job.
    pub of: &'t J,
    /// The numbers of the job in the behaviour file.
    pub own: &'t J::Numbers,
    /// Those about the arm.
    pub numbers: &'t ArmNumbers,
    /// What is seen, and where goals and the log go.
    pub world: World<'t>,
    /// What is remembered of the arm.
    pub arm: &'t mut ArmMemory,
    /// And besides.
    pub memory: &'t mut J::Memory,
    /// The state at the start of the decision.
    pub state: J::State,
    /// Policy time.
    pub now: PolicyTime,
    /// Measured TCP, world frame.
    pub tcp: Pose,
    /// Measured gripper.
    pub gripper: &'t GripperState,
    /// What changed about the grip.
    pub grip: GripChange,
    /// What was reached on the path.
    pub reached: Reached,
}

/// An object as it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its pose, world frame.
    pub pose: Isometry3<f64>,
    /// It does not move, and the operator does not drag it.
    pub at_rest: bool,
}

impl Seen {
    /// An object; `None` where it is not in the cell.
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
    /// An object; `None` where it is not in the cell.
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

    /// A new path from where the TCP is.
    pub fn route(&mut self) -> Route<'_> {
        self.arm.wait_until = self.now;
        let paces = self.of.paces(self.own);
        Route::new(&mut self.arm.path, paces, self.tcp, self.now)
    }

    /// Whether the arm is on its path, as if no decision had been missed; `None`
    /// where it has no path.
    pub fn is_on_path(&self) -> Option<bool> {
        let within = self.numbers.resume_m;
        self.arm.path.is_near(&self.tcp, within, self.now)
    }

    /// Whether the state has lasted longer than `limit`.
    pub fn is_late(&self, limit: PolicyTime) -> bool {
        self.now.since(self.arm.since) > limit
    }

    /// Counts a failed pick-up of an object; from `most` in a row on the job fails
    /// for `reason`. Answers whether it did.
    pub fn count_failed_pick(&mut self, object: usize, most: u32, reason: &str) -> bool {
        let attempts = self.world.job.attempts_mut(object);
        let failed = attempts.is_some_and(|attempts| {
            attempts.pick += 1;
            attempts.pick >= most
        });
        if failed {
            let name = self.name(object);
            let why = format_args!("{name} was not gripped again and again");
            self.world.fail(reason, why);
        }
        failed
    }

    /// Says that an object is not attached any more, and why its grip broke; `counts`
    /// where that is a drop.
    pub fn note_drop(&mut self, object: usize, counts: bool) {
        self.world.job.counters.drops += u32::from(counts);
        let (name, gripper) = (self.name(object), self.gripper);
        let out = &mut *self.world.out;
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

    /// Never: the event is there for a file that names it.
    pub fn never<J: MatrixJob>(_turn: &Turn<'_, J>) -> bool {
        false
    }
}
