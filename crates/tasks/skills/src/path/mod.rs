//! A path of waypoints, with paces, postures, corridors and obstacles for each, and motions of
//! the joints.

mod precision;
mod route;
mod waypoint;

use ipc_types::decision::{GoalKind, PLANNED};
use ipc_types::{GripperGoal, MAX_JOINTS, Pose};
use robocell_task::{ArmIntent, PolicyTime};
use serde::{Deserialize, Serialize};

use crate::pose::{self, KeptPose};
pub use precision::Precision;
pub use route::{Paces, Route};
pub use waypoint::{MAX_APPROACH_M, MAX_WAYPOINTS, Waypoint};

/// Upper bound of the number of moves in a checkpoint; no run has so many.
const MOST_MOVES: u64 = 1 << 62;

/// Progress of the path in one decision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reached {
    /// Nothing was reached, or there is no path.
    Nothing,
    /// A waypoint that is not the last.
    Waypoint,
    /// The last waypoint. Reported once for each move.
    Goal,
}

/// Waypoints of one arm, first in, first out, and the present target. Part of a policy's
/// record.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    /// The first one is in progress; it stays if it is the last.
    waypoints: Vec<Waypoint>,
    /// Start and time of the glide to the first.
    glide: Option<Glide>,
    /// Whether the last waypoint has not been reached yet.
    moving: bool,
    /// Number of moves: each of them is a separate goal for the controller.
    key: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Glide {
    from: KeptPose,
    since: PolicyTime,
}

impl Path {
    /// An empty path, with memory for a whole one, so that no decision allocates.
    pub fn new() -> Self {
        Self {
            waypoints: Vec::with_capacity(MAX_WAYPOINTS),
            ..Self::default()
        }
    }

    /// Drops the path: the arm holds. The number of moves continues.
    pub fn stop(&mut self) {
        self.waypoints.clear();
        self.glide = None;
        self.moving = false;
    }

    /// Replaces the path by `waypoint`. A glide starts at `start`: the target so far, or the
    /// measured cup.
    pub fn go(&mut self, waypoint: Waypoint, start: &Pose, now: PolicyTime) {
        self.stop();
        self.waypoints.push(waypoint);
        self.begin(start, now);
    }

    /// Appends `waypoint`. Returns whether there was room.
    pub fn then(&mut self, waypoint: Waypoint) -> bool {
        let fits = self.moving && self.waypoints.len() < MAX_WAYPOINTS;
        if fits {
            self.waypoints.push(waypoint);
        }
        fits
    }

    /// Replaces the last waypoint without a new move. Does nothing if no move is in progress.
    pub fn aim(&mut self, waypoint: Waypoint) {
        if let Some(last) = self.waypoints.last_mut().filter(|_| self.moving) {
            *last = waypoint;
        }
    }

    /// The last waypoint has to be reached again, without a new move: if it is reached already,
    /// the next step reports it.
    pub fn again(&mut self) {
        self.moving = !self.waypoints.is_empty();
    }

    /// Whether the last waypoint is still to be reached.
    pub fn is_moving(&self) -> bool {
        self.moving
    }

    /// Whether the waypoint in progress is the last one.
    pub fn is_last(&self) -> bool {
        self.waypoints.len() <= 1
    }

    /// The last waypoint of the path.
    pub fn end(&self) -> Option<&Waypoint> {
        self.waypoints.last()
    }

    /// Compares the TCP with the waypoint in progress, and starts the next one as soon as it is
    /// reached: within `passing` if it is not the last, else within `goal`.
    pub fn step(
        &mut self,
        measured: &Pose,
        [passing, goal]: [Precision; 2],
        now: PolicyTime,
    ) -> Reached {
        let Some(first) = self.waypoints.first().filter(|_| self.moving) else {
            return Reached::Nothing;
        };
        let last = self.is_last();
        let precision = if last { goal } else { passing };
        // The glide has to end, too: a slow target may pass near the waypoint before it gets
        // there.
        if self.part(now) < 1.0 || !precision.reached(&first.pose(), measured) {
            return Reached::Nothing;
        }
        if last {
            self.moving = false;
            return Reached::Goal;
        }
        // From the waypoint, not from the TCP: the target must not jump back by the arm's lag.
        let start = first.pose();
        self.waypoints.remove(0);
        self.begin(&start, now);
        Reached::Waypoint
    }

    /// The present target; `None` without a path.
    pub fn target(&self, now: PolicyTime) -> Option<Pose> {
        let pose = self.waypoints.first()?.pose();
        let Some(glide) = self.glide else {
            return Some(pose::with_unit_quaternion(&pose));
        };
        Some(pose::between(&glide.from.into(), &pose, self.part(now)))
    }

    /// The goal of the arm: the target, or to hold.
    pub fn intent(&self, gripper: GripperGoal, now: PolicyTime) -> ArmIntent {
        let held = ArmIntent {
            gripper,
            key: self.key,
            ..ArmIntent::default()
        };
        let (Some(first), Some(target)) = (self.waypoints.first(), self.target(now)) else {
            return held;
        };
        ArmIntent {
            kind: if first.by_joints {
                GoalKind::Joints
            } else {
                GoalKind::Pose
            },
            target,
            selector: if first.planned { PLANNED } else { 0 },
            posture: first.posture,
            approach: first.approach,
            approach_std_dev: first.approach_std_dev,
            obstacle_mask: first.obstacle_mask,
            object_mask: first.object_mask,
            ..held
        }
    }

    /// Whether a restored path is valid: its length, its poses, and the number of moves.
    pub fn is_sound(&self) -> bool {
        self.waypoints.len() <= MAX_WAYPOINTS
            && self.key < MOST_MOVES
            && self.waypoints.iter().all(Waypoint::is_sound)
            && self.glide.is_none_or(|glide| glide.from.is_sound())
    }

    /// Whether a TCP measured at `measured` is nearer to the target than `within_m`; `None`
    /// without a path.
    pub fn is_near(&self, measured: &Pose, within_m: f64, now: PolicyTime) -> Option<bool> {
        self.target(now)
            .map(|target| pose::distance(&target, measured) <= within_m)
    }

    fn begin(&mut self, start: &Pose, now: PolicyTime) {
        self.moving = true;
        self.key += 1;
        let glides = self
            .waypoints
            .first()
            .is_some_and(|first| first.glide_ticks > 0);
        self.glide = glides.then_some(Glide {
            from: (*start).into(),
            since: now,
        });
    }

    /// Share of the glide that has passed, 0 to 1.
    fn part(&self, now: PolicyTime) -> f64 {
        let (Some(glide), Some(first)) = (self.glide, self.waypoints.first()) else {
            return 1.0;
        };
        let gone = now.since(glide.since).ticks().min(first.glide_ticks);
        gone as f64 / first.glide_ticks.max(1) as f64
    }
}

/// Positions of the first joints in the form of a message: the others are 0.
pub fn padded(posture: &[f64]) -> [f64; MAX_JOINTS] {
    let mut joints = [0.0; MAX_JOINTS];
    for (slot, position) in joints.iter_mut().zip(posture) {
        *slot = *position;
    }
    joints
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::straight_down_by_x as straight_down;

    fn at(x: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            orientation_wxyz: straight_down(0.0),
        }
    }

    const FINE: [Precision; 2] = [Precision::new(0.18, 0.6), Precision::new(0.0005, 0.0025)];

    fn ms(ticks: u64) -> PolicyTime {
        PolicyTime::from_ticks(ticks)
    }

    #[test]
    fn waypoints_on_the_way_are_passed_and_the_last_is_reached_once() {
        let mut motion = Path::new();
        assert_eq!(motion.step(&at(0.0), FINE, ms(0)), Reached::Nothing);
        motion.go(Waypoint::new(at(0.5)), &at(0.0), ms(0));
        assert!(motion.then(Waypoint::new(at(1.0))));
        assert_eq!(motion.step(&at(0.3), FINE, ms(10)), Reached::Nothing);
        assert_eq!(motion.step(&at(0.35), FINE, ms(20)), Reached::Waypoint);
        assert_eq!(motion.target(ms(20)), Some(at(1.0)));
        assert_eq!(motion.step(&at(0.999), FINE, ms(30)), Reached::Nothing);
        assert_eq!(motion.step(&at(0.9996), FINE, ms(40)), Reached::Goal);
        assert_eq!(
            motion.step(&at(0.9996), FINE, ms(50)),
            Reached::Nothing,
            "once"
        );
        assert_eq!(motion.target(ms(50)), Some(at(1.0)), "and is held");
        motion.again();
        assert_eq!(motion.step(&at(1.0), FINE, ms(60)), Reached::Goal);
        assert!(!motion.then(Waypoint::new(at(2.0))));
    }

    #[test]
    fn a_glide_takes_its_time_and_survives_a_record() {
        let mut motion = Path::new();
        motion.go(Waypoint::new(at(1.0)).gliding(1000), &at(0.0), ms(500));
        let x = |motion: &Path, now| motion.target(ms(now)).unwrap().position[0];
        assert!((x(&motion, 750) - 0.25).abs() < 1.0e-12);
        let bytes = robocell_task::checkpoint::to_bytes(&motion);
        let mut motion: Path = robocell_task::checkpoint::from_bytes(&bytes).unwrap();
        assert!((x(&motion, 1250) - 0.75).abs() < 1.0e-12);
        assert_eq!(motion.step(&at(1.0), FINE, ms(1490)), Reached::Nothing);
        assert_eq!(motion.step(&at(1.0), FINE, ms(1500)), Reached::Goal);
    }

    #[test]
    fn aiming_again_is_no_new_goal_and_a_move_is() {
        let mut motion = Path::new();
        let key = |motion: &Path| motion.intent(GripperGoal::Open, ms(0)).key;
        motion.aim(Waypoint::new(at(9.0)));
        let hold = motion.intent(GripperGoal::Open, ms(0));
        assert_eq!(hold.kind, GoalKind::Hold, "nowhere to go");
        motion.go(Waypoint::new(at(1.0)), &at(0.0), ms(0));
        let first = key(&motion);
        motion.aim(Waypoint::new(at(2.0)).leaning(padded(&[0.5; 6])));
        let intent = motion.intent(GripperGoal::Close, ms(0));
        assert_eq!((intent.key, intent.target), (first, at(2.0)));
        assert_eq!(
            intent.posture.unwrap()[..7],
            [0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.0]
        );
        motion.stop();
        motion.go(Waypoint::new(at(2.0)), &at(0.0), ms(0));
        assert!(key(&motion) > first);
    }

    #[test]
    fn a_path_has_an_end() {
        let mut motion = Path::new();
        motion.go(Waypoint::new(at(1.0)), &at(0.0), ms(0));
        let taken = (0..40).filter(|_| motion.then(Waypoint::new(at(1.0))));
        assert_eq!(taken.count(), MAX_WAYPOINTS - 1);
        assert!(motion.is_sound());
    }
}
