//! A path under construction: poses with a pace.

use ipc_types::{MAX_JOINTS, Pose};
use nalgebra::Vector3;
use robocell_task::PolicyTime;

use super::{Path, Waypoint};
use crate::geometry;
use crate::pose;
use crate::setup::ArmSetup;

/// Smallest duration of a motion that restores the joints (ticks): a pose does not distinguish
/// two configurations of an arm, so it could be reached at once; in this time any joint can
/// turn once.
const RESTORE_TICKS: u64 = 5_000;

/// The pace of the target. With a pace of 0 the target jumps: the arm then moves as fast as its
/// controller allows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paces {
    /// On long motions (m/s).
    pub speed_m_s: f64,
    /// Where the tool is about to touch or to release an object (m/s).
    pub slow_speed_m_s: f64,
    /// Of turns (rad/s).
    pub turn_speed_rad_s: f64,
}

/// Replaces a [`Path`], waypoint by waypoint. A route of more than [`super::MAX_WAYPOINTS`] is
/// not followed: without its end it would lead elsewhere.
pub struct Route<'p> {
    path: &'p mut Path,
    paces: Paces,
    now: PolicyTime,
    at: Pose,
    begun: bool,
    obstacles: u64,
    lean: Option<[f64; MAX_JOINTS]>,
}

impl<'p> Route<'p> {
    /// Replaces `path` with the first waypoint; the route starts at `from`.
    pub fn new(path: &'p mut Path, paces: Paces, from: Pose, now: PolicyTime) -> Self {
        Self {
            path,
            paces,
            now,
            at: from,
            begun: false,
            obstacles: u64::MAX,
            lean: None,
        }
    }

    /// Leans to a joint configuration from here on (rad).
    #[must_use]
    pub fn leaning(mut self, joints: [f64; MAX_JOINTS]) -> Self {
        self.lean = Some(joints);
        self
    }

    /// Only these fixtures are obstacles from here on.
    #[must_use]
    pub fn avoiding(mut self, obstacles: u64) -> Self {
        self.obstacles = obstacles;
        self
    }

    /// To `joints`, whose TCP pose is `pose`, with the joints alone, and without leaning
    /// afterwards. At a singular wrist a path of poses would turn two joints instead of one.
    #[must_use]
    pub fn by_joints(mut self, pose: Pose, joints: [f64; MAX_JOINTS]) -> Self {
        self.lean = None;
        self.put(Waypoint::new(pose).by_joints(joints))
    }

    /// To the start configuration of `arm`, with the joints alone. For an arm that the operator
    /// led, or that did not arrive: its elbow or wrist may be in another branch, from which a
    /// path of poses ends at the limit of a joint.
    #[must_use]
    pub fn restoring(mut self, arm: &ArmSetup) -> Self {
        self.lean = None;
        let waypoint = Waypoint::new(arm.wait).by_joints(arm.home);
        self.put(waypoint.gliding(RESTORE_TICKS))
    }

    /// To the start configuration of `arm` along a planned path, around obstacles, the arm's
    /// own base among them (ADR 0021).
    #[must_use]
    pub fn planned_home(mut self, arm: &ArmSetup) -> Self {
        self.lean = None;
        self.put(Waypoint::new(arm.wait).by_joints(arm.home).planned())
    }

    /// To `pose` at the pace of long motions.
    #[must_use]
    pub fn to(self, pose: Pose) -> Self {
        let speed = self.paces.speed_m_s;
        self.at_pace(pose, speed)
    }

    /// To `pose` slowly.
    #[must_use]
    pub fn slowly(self, pose: Pose) -> Self {
        let speed = self.paces.slow_speed_m_s;
        self.at_pace(pose, speed)
    }

    /// To `pose` in `time`; 0 makes the target jump.
    #[must_use]
    pub fn within(self, time: PolicyTime, pose: Pose) -> Self {
        let lean = self.lean;
        self.put(Waypoint {
            posture: lean,
            ..Waypoint::new(pose).gliding(time.ticks())
        })
    }

    /// Waits at the present pose for `time`: the arm lags behind a moving target, and arrives
    /// meanwhile.
    #[must_use]
    pub fn wait(self, time: PolicyTime) -> Self {
        if time.ticks() == 0 {
            return self;
        }
        let pose = self.at;
        self.within(time, pose)
    }

    /// Straight up to the height `to_m`, and by at least `least_m`.
    #[must_use]
    pub fn lift(self, to_m: f64, least_m: f64) -> Self {
        let [_, _, z] = self.at.position;
        let up = (to_m - z).max(least_m);
        let pose = pose::shifted(&self.at, [0.0, 0.0, up]);
        self.to(pose)
    }

    /// To `pose`, over `via` if the directions of both ends from the vertical axis through
    /// `base` differ by more than `most_rad`: the arm itself is in between.
    #[must_use]
    pub fn around_to(self, base: Vector3<f64>, most_rad: f64, via: Pose, pose: Pose) -> Self {
        let direction = |p: &Pose| {
            let off = Vector3::from(p.position) - base;
            libm::atan2(off.y, off.x)
        };
        let turn = (direction(&self.at) - direction(&pose)).abs();
        if turn < most_rad {
            return self.to(pose);
        }
        self.to(via).to(pose)
    }

    /// Ends the route.
    pub fn end(self) {}

    fn at_pace(self, pose: Pose, speed: f64) -> Self {
        let ticks = ticks_between(&self.at, &pose, speed, self.paces.turn_speed_rad_s);
        self.within(PolicyTime::from_ticks(ticks), pose)
    }

    fn put(mut self, waypoint: Waypoint) -> Self {
        let waypoint = waypoint.avoiding(self.obstacles, u64::MAX);
        if self.begun {
            // Too long: the arm stops instead of ending at a waypoint that was meant to be
            // passed.
            if !self.path.then(waypoint) {
                self.path.stop();
            }
        } else {
            self.path.go(waypoint, &self.at, self.now);
            self.begun = true;
        }
        self.at = waypoint.pose();
        self
    }
}

/// Time from one pose to another at `speed` (m/s) and `turn` (rad/s), in ticks.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "lengths of ways divided by paces of a file: seconds, not negative"
)]
fn ticks_between(from: &Pose, to: &Pose, speed: f64, turn: f64) -> u64 {
    let angle = geometry::angle_between(from.orientation_wxyz, to.orientation_wxyz);
    let share = |way: f64, pace: f64| if pace > 0.0 { way / pace } else { 0.0 };
    // The slower of the two, so that neither pace is exceeded.
    let seconds = share(pose::distance(from, to), speed).max(share(angle, turn));
    (seconds * 1000.0).ceil() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::{Precision, Reached};

    fn at(x: f64) -> Pose {
        Pose {
            position: [x, 0.0, 0.0],
            ..Pose::IDENTITY
        }
    }

    const PACES: Paces = Paces {
        speed_m_s: 0.5,
        slow_speed_m_s: 0.1,
        turn_speed_rad_s: 1.0,
    };
    const FINE: [Precision; 2] = [Precision::new(0.01, 0.1); 2];

    fn ms(ticks: u64) -> PolicyTime {
        PolicyTime::from_ticks(ticks)
    }

    #[test]
    fn a_pace_is_a_time() {
        let mut path = Path::new();
        let route = Route::new(&mut path, PACES, at(0.0), ms(0));
        route.to(at(1.0)).wait(ms(300)).slowly(at(1.1)).end();
        assert_eq!(path.step(&at(1.0), FINE, ms(1990)), Reached::Nothing);
        assert_eq!(path.step(&at(1.0), FINE, ms(2000)), Reached::Waypoint);
        assert_eq!(path.step(&at(1.0), FINE, ms(2290)), Reached::Nothing);
        assert_eq!(path.step(&at(1.0), FINE, ms(2300)), Reached::Waypoint);
        assert_eq!(path.step(&at(1.1), FINE, ms(3290)), Reached::Nothing);
        assert_eq!(path.step(&at(1.1), FINE, ms(3310)), Reached::Goal);
    }

    #[test]
    fn the_arm_is_gone_around() {
        let behind = Pose {
            position: [-1.0, 0.1, 0.0],
            ..Pose::IDENTITY
        };
        let waypoints = |to: Pose| {
            let mut path = Path::new();
            let route = Route::new(&mut path, PACES, at(1.0), ms(0));
            route.around_to(Vector3::zeros(), 1.1, at(0.5), to).end();
            path.is_last()
        };
        assert!(waypoints(at(0.8)));
        assert!(!waypoints(behind));
    }
}
