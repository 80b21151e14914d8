//! Conditions under which a path is planned for an arm, and how the arm is led along it.
//!
//! Planning takes from a fraction of a millisecond to some 100 ms, a cycle has one (ADR 0021).
//! So a cycle only makes a request, a plain value. It is answered by [`planner`] outside of
//! the cycle, in a thread of the controller process ([`worker`]) or by the caller, and taken
//! [`ANSWER_TICKS`] later. Until then, and where no path is needed, motion policies move the
//! arm alone.
//!
//! The rules that keep runs equal to the bit: the answer depends on nothing but the request;
//! it is taken at a tick that follows from the request, not from the scheduler; request, path
//! and progress are in the checkpoint. An answer to another request than the one in flight is
//! dropped, since its goal or its obstacles are old. Nothing is allocated or freed in a cycle:
//! answers are swapped, and the old ones are dropped by the planner's side.

mod goal;
mod path_follower;
pub mod planner;
pub mod request;
pub mod worker;

use ipc_types::arm::{NotReached, PATH_POINTS, PlanState};
use nalgebra::{Isometry3, Vector3};
use rmp::{MotionState, ObstacleId, ObstacleSet};

pub use goal::PlanGoal;
pub use planner::{PlanAnswer, Planner};
pub use request::{Ask, PlanRequest};

use crate::checkpoint::{CheckpointError, Codec, damaged};
use path_follower::PathFollower;

/// Ticks from a request to its answer. In real time a late answer is taken when it arrives; in
/// lockstep it is waited for.
// Far above the p95 of a search, 4.5 to 5.8 ms (ADR 0019). One without a result takes some 100
// ms, and its answer would change nothing.
pub const ANSWER_TICKS: u64 = 50;
/// Displacement of a goal from which a new path is planned (m, rad).
// Within this the end of the path still leads to the goal, which motion policies then reach
// (ADR 0021).
const MOVED_M: f64 = 0.02;
const MOVED_RAD: f64 = 0.1;
/// Displacement of a goal from which the present path is dropped at once (m).
const JUMPED_M: f64 = 0.2;
/// Nearer goals are left to motion policies, until the arm is stuck (m, rad).
// Targets that glide cause no request (ADR 0021).
const FAR_M: f64 = 0.1;
const FAR_RAD: f64 = 0.5;
/// Distance at which the tool is at its goal (m, rad).
const NEAR_M: f64 = 0.005;
const NEAR_RAD: f64 = 0.05;
/// An arm is stuck if for so many ticks its tool comes no nearer to its goal than by this (m,
/// rad), and its joints are slower than this (rad/s or m/s).
const STUCK_M: f64 = 0.002;
const STUCK_RAD: f64 = 0.02;
const STUCK_SPEED: f64 = 0.1;
const STUCK_TICKS: u64 = 500;
/// Ticks from a negative answer to the next request.
// Obstacles and other arms move; without a new request an arm would stay blocked for ever.
const RETRY_TICKS: u64 = 500;
/// Interval of the checks of the path ahead (ticks), and their length (rad and m alike).
// Farther than the 0.6 rad that the arm is led ahead, so a new path is requested before the
// old one is blocked at the arm (ADR 0021).
const LOOK_TICKS: u64 = 10;
const LOOK_AHEAD: f64 = 1.0;

/// The reason to show for a goal that had the reason `before`, after another search gave
/// `now`.
///
/// Each search starts from other joint positions. A search that found positions with the pose
/// has proved that they exist; a later one that finds none missed them, and people would see
/// the reason change with each search.
fn confirmed(before: NotReached, now: NotReached) -> NotReached {
    use NotReached::{Blocked, JointLimit, LocalMinimum, Singular, Unreachable};
    match (before, now) {
        (Blocked | Singular | LocalMinimum, JointLimit | Unreachable)
        | (JointLimit, Unreachable) => before,
        _ => now,
    }
}

/// The inputs of planning in one cycle.
pub(crate) struct Moment<'a> {
    pub(crate) tick: u64,
    pub(crate) goal: Option<&'a PlanGoal>,
    /// TCP in the base frame.
    pub(crate) tool: &'a Isometry3<f64>,
    pub(crate) state: &'a MotionState,
    pub(crate) posture: &'a [f64],
    /// Spheres of the held object, in the tool frame.
    pub(crate) held: &'a [(Vector3<f64>, f64)],
    pub(crate) obstacles: &'a ObstacleSet,
    /// The solid ones of the first 64 obstacles.
    pub(crate) solid_mask: u64,
}

impl Moment<'_> {
    /// The obstacles that paths keep away from.
    pub(crate) fn solids(&self) -> impl Iterator<Item = ObstacleId> {
        let is_solid = |index: &usize| *index >= 64 || self.solid_mask >> index & 1 == 1;
        let ids = (0..self.obstacles.len()).filter(is_solid).map(ObstacleId);
        ids.filter(|id| self.obstacles.is_enabled(*id))
    }
}

/// The report on planning for the status.
pub(crate) struct PlanReport {
    pub(crate) state: PlanState,
    pub(crate) not_reached: NotReached,
    pub(crate) answered: u64,
    /// Progress and length of the path, and points of it in the world frame (m).
    pub(crate) path: Option<(f64, f64, [[f64; 3]; PATH_POINTS])>,
}

/// The requests of one arm and the path that leads it.
#[derive(Debug)]
pub(crate) struct Planning {
    /// Whether paths lead the arm to every goal; else only out of where it is stuck.
    is_on: bool,
    arm: planner::PlannedArm,
    /// Goal of the last request.
    goal: Option<PlanGoal>,
    request: PlanRequest,
    is_in_flight: bool,
    answered: u64,
    not_reached: NotReached,
    /// An answer that was not used yet, or the one it replaced: memory is not freed in a
    /// cycle.
    inbox: Option<PlanAnswer>,
    follower: Option<PathFollower>,
    /// Whether `follower` is in use.
    is_following: bool,
    /// Distance of the tool from its goal at the last progress of the arm (m, rad), and the
    /// ticks since then.
    last_off: (f64, f64),
    stuck_ticks: u64,
    /// No request is made before this tick.
    quiet_until: u64,
}

impl Planning {
    pub(crate) fn new(arm: planner::PlannedArm, obstacles: usize) -> Self {
        Self {
            is_on: false,
            request: PlanRequest::with_capacity(arm.joint_count(), obstacles),
            arm,
            goal: None,
            is_in_flight: false,
            answered: 0,
            not_reached: NotReached::None,
            inbox: None,
            follower: None,
            is_following: false,
            last_off: (0.0, 0.0),
            stuck_ticks: 0,
            quiet_until: 0,
        }
    }

    /// An empty request, to copy one into.
    pub(crate) fn empty_request(&self) -> PlanRequest {
        let joints = self.arm.joint_count();
        PlanRequest::with_capacity(joints, self.request.obstacle_capacity())
    }

    /// The request that waits for its answer.
    // An answer in the inbox is taken in the next cycle: the request does not wait any more.
    pub(crate) fn request(&self) -> Option<&PlanRequest> {
        let is_answered = |answer: &PlanAnswer| answer.id == self.request.id;
        let waits = self.is_in_flight && !self.inbox.as_ref().is_some_and(is_answered);
        waits.then_some(&self.request)
    }

    /// Takes the answer in `slot` for the next cycle, and leaves the previous one there to be
    /// dropped.
    pub(crate) fn answer(&mut self, slot: &mut Option<PlanAnswer>) {
        std::mem::swap(&mut self.inbox, slot);
    }

    /// Removes goal and path; an answer in flight is dropped when it arrives.
    pub(crate) fn clear(&mut self) {
        self.goal = None;
        self.is_in_flight = false;
        self.is_following = false;
        self.not_reached = NotReached::None;
        self.stuck_ticks = 0;
        self.quiet_until = 0;
    }

    pub(crate) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Sets whether paths lead the arm. A goal that was planned before is planned again: the
    /// arm may be at any place by now.
    pub(crate) fn set_on(&mut self, is_on: bool) {
        if is_on != self.is_on {
            self.is_on = is_on;
            self.clear();
        }
    }

    pub(crate) fn is_following(&self) -> bool {
        self.is_following
    }

    /// Takes an answer, and makes a request if one is needed. Allocates nothing.
    pub(crate) fn update(&mut self, now: &Moment<'_>) {
        // No goal of the tool: the arm holds, or another controller moves it.
        let Some(goal) = now.goal else {
            self.clear();
            return;
        };
        // Before the new request: an answer of this tick may make it superfluous.
        self.take_answer(now.tick);
        let off = self.goal.as_ref().map(|planned| planned.off(goal));
        let has_moved = off.is_none_or(|(m, rad)| m > MOVED_M || rad > MOVED_RAD);
        // A path to a goal that jumped leads away from it; motion policies are better until
        // the new path is there.
        if off.is_none_or(|(m, _)| m > JUMPED_M) || (has_moved && !self.is_on) {
            self.is_following = false;
        }
        let (m, rad) = goal.off_pose(now.tool);
        self.watch(now, (m, rad));
        let is_far = m > FAR_M || rad > FAR_RAD;
        // The scene of the guide is the present one: a path is only valid among the obstacles
        // that it was checked with.
        if let Some(follower) = self.follower.as_mut().filter(|_| self.is_following) {
            let parts = now.solids().flat_map(|id| now.obstacles.parts(id));
            follower.guide.scene.set(parts);
            self.is_following = !follower.is_done(goal, &now.state.positions);
        }
        if !self.is_in_flight
            && now.tick >= self.quiet_until
            && let Some(ask) = self.wanted(now.tick, has_moved && is_far)
        {
            // The reason of the old goal does not apply to the new one.
            if has_moved {
                self.not_reached = NotReached::None;
            }
            self.goal = Some(*goal);
            self.request.fill(ask, now, goal);
            self.is_in_flight = true;
        }
    }

    fn take_answer(&mut self, tick: u64) {
        let Some(answer) = &mut self.inbox else {
            return;
        };
        // The answer is to a request that was given up.
        if !self.is_in_flight || answer.id != self.request.id {
            return;
        }
        self.is_in_flight = false;
        self.answered = answer.id;
        self.not_reached = confirmed(self.not_reached, answer.not_reached);
        // A reason leads no arm: the path in use, if any, stays.
        if self.request.ask == Ask::Reason {
            self.quiet_until = if self.needs_detour() {
                tick
            } else {
                tick + RETRY_TICKS
            };
            return;
        }
        self.is_following = answer.follower.is_some();
        std::mem::swap(&mut self.follower, &mut answer.follower);
        if answer.not_reached != NotReached::None {
            self.quiet_until = tick + RETRY_TICKS;
        }
    }

    /// Whether motion policies alone never get out of where the arm is stuck.
    fn needs_detour(&self) -> bool {
        matches!(
            self.not_reached,
            NotReached::JointLimit | NotReached::LocalMinimum
        )
    }

    /// Counts the ticks for which the arm has been stuck away from its goal.
    fn watch(&mut self, now: &Moment<'_>, (m, rad): (f64, f64)) {
        let is_there = m < NEAR_M && rad < NEAR_RAD;
        let is_slow = now.state.velocities.iter().all(|v| v.abs() < STUCK_SPEED);
        let (last_m, last_rad) = self.last_off;
        let comes_nearer = m < last_m - STUCK_M || rad < last_rad - STUCK_RAD;
        if is_there || !is_slow || comes_nearer {
            (self.last_off, self.stuck_ticks) = ((m, rad), 0);
            // With a planner it stays until another answer arrives, or it would flicker with
            // each move.
            if is_there || !self.is_on {
                self.not_reached = NotReached::None;
            }
        } else {
            self.stuck_ticks += 1;
        }
    }

    fn wanted(&mut self, tick: u64, is_new: bool) -> Option<Ask> {
        let is_stuck = self.stuck_ticks >= STUCK_TICKS;
        if !self.is_on && !self.is_following {
            let ask = if self.needs_detour() {
                Ask::Detour
            } else {
                Ask::Reason
            };
            return is_stuck.then_some(ask);
        }
        if self.is_on && is_new {
            return Some(Ask::Path);
        }
        let checks = self.is_following && tick.is_multiple_of(LOOK_TICKS);
        let follower = self.follower.as_mut().filter(|_| checks);
        if follower.is_some_and(|follower| !follower.guide.is_free_ahead(LOOK_AHEAD)) {
            return Some(Ask::Path);
        }
        let failed = self.not_reached != NotReached::None;
        (is_stuck || failed).then_some(Ask::Detour)
    }

    /// Joint positions (rad or m) to lead an arm at `positions` to, and whether the tool may
    /// move to its goal; `None` if no path leads it. Allocates nothing.
    pub(crate) fn lead(&mut self, positions: &[f64]) -> Option<(&[f64], bool)> {
        let follower = self.follower.as_mut().filter(|_| self.is_following)?;
        Some(follower.lead(positions))
    }

    pub(crate) fn report(&self) -> PlanReport {
        let follower = self.follower.as_ref().filter(|_| self.is_following);
        let path = follower.map(|follower| {
            let (at, length) = follower.guide.progress();
            (at, length, follower.points)
        });
        PlanReport {
            state: match (path.is_some(), self.is_in_flight) {
                (true, _) => PlanState::Led,
                (false, true) => PlanState::Requested,
                (false, false) => PlanState::None,
            },
            not_reached: self.not_reached,
            answered: self.answered,
            path,
        }
    }

    /// Writes or reads the state from cycle to cycle.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.bool("planner", &mut self.is_on)?;
        codec.option("planned goal", &mut self.goal, |codec, goal| {
            goal.checkpoint(codec)
        })?;
        codec.bool("request", &mut self.is_in_flight)?;
        self.request.checkpoint(codec, self.is_in_flight)?;
        codec.u64(&mut self.answered)?;
        let mut code = self.not_reached.code();
        codec.u32(&mut code)?;
        let known = NotReached::from_code(code);
        self.not_reached = known.ok_or(damaged("reason", u64::from(code)))?;
        codec.f64(&mut self.last_off.0)?;
        codec.f64(&mut self.last_off.1)?;
        codec.u64(&mut self.stuck_ticks)?;
        codec.u64(&mut self.quiet_until)?;
        codec.bool("led", &mut self.is_following)?;
        // A path that is not in use is not recorded: it would never be used again.
        if !self.is_following {
            return Ok(());
        }
        let capacity = self.request.obstacle_capacity();
        PathFollower::checkpoint(&mut self.follower, codec, &self.arm, capacity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_that_misses_known_positions_does_not_change_the_reason() {
        use NotReached::{Blocked, InCollision, JointLimit, None, Unreachable};
        for (before, now, shown) in [
            (None, JointLimit, JointLimit),
            (JointLimit, Blocked, Blocked),
            (Blocked, JointLimit, Blocked),
            (Blocked, Unreachable, Blocked),
            (JointLimit, Unreachable, JointLimit),
            (Blocked, InCollision, InCollision),
            (Blocked, None, None),
        ] {
            assert_eq!(confirmed(before, now), shown, "{before:?}, then {now:?}");
        }
    }
}
