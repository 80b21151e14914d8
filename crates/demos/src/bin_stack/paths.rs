//! Ways of the cup, as waypoints.

use ipc_types::Pose;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::columns::{Slot, half_turn_quaternion};
use super::scene::Bin;
use super::setup::BinStackSetup;
use robocell_skills::geometry::{self, straight_down_by_x as straight_down};
use robocell_skills::path::padded;
use robocell_skills::pose::{self, approach};
use robocell_skills::{Path, Waypoint};
use robocell_task::time::PolicyTime;

/// Where a precise stop is needed on the way, the target waits this long: the
/// arm follows a moving target some 0.11 s behind.
const SETTLE: u64 = 500;
/// Above the carrying height a bin is lifted at least this much (m).
const LEAST_LIFT_M: f64 = 0.12;
/// Between places whose directions from the arm differ by more than this the
/// way leads around the arm (rad).
const AROUND_RAD: f64 = 1.1;

/// A way under construction: it remembers where its last waypoint is.
pub(super) struct Route<'a> {
    setup: &'a BinStackSetup,
    motion: &'a mut Path,
    now: PolicyTime,
    at: Pose,
    begun: bool,
    obstacles: u64,
    lean: Option<[f64; ipc_types::MAX_JOINTS]>,
}

impl<'a> Route<'a> {
    /// From where the cup is.
    pub(super) fn from(
        setup: &'a BinStackSetup,
        motion: &'a mut Path,
        tcp: Pose,
        now: PolicyTime,
    ) -> Self {
        Self {
            setup,
            motion,
            now,
            at: tcp,
            begun: false,
            obstacles: u64::MAX,
            lean: None,
        }
    }

    /// Leaning to a joint configuration from here on (rad).
    pub(super) fn leaning(mut self, joints: [f64; 6]) -> Self {
        self.lean = Some(padded(&joints));
        self
    }

    /// Turns over with the joints alone, to a configuration whose cup pose is
    /// `pose`: sideways the wrist is singular, and a path of poses would turn
    /// two joints instead of one there.
    pub(super) fn by_joints(mut self, pose: Pose, joints: [f64; 6]) -> Self {
        let waypoint = Waypoint::new(pose).by_joints(padded(&joints));
        self.lean = None;
        self.put(waypoint)
    }

    /// Without keeping away from the flipping station from here on.
    pub(super) fn into_holder(mut self) -> Self {
        self.obstacles = self.setup.without_holder;
        self
    }

    /// Keeping away from everything from here on.
    pub(super) fn clear_of_holder(mut self) -> Self {
        self.obstacles = u64::MAX;
        self
    }

    /// To `pose` at the pace of long ways.
    pub(super) fn to(self, pose: Pose) -> Self {
        let speed = self.setup.task.speed_m_s;
        self.at_pace(pose, speed)
    }

    /// To `pose` slowly.
    pub(super) fn slowly(self, pose: Pose) -> Self {
        let speed = self.setup.task.slow_speed_m_s;
        self.at_pace(pose, speed)
    }

    /// To `pose` in that time.
    pub(super) fn in_ticks(self, pose: Pose, ticks: u64) -> Self {
        self.push(pose, ticks)
    }

    /// Waits where it is, at least `ticks`.
    pub(super) fn wait(self, ticks: u64) -> Self {
        let pose = self.at;
        self.push(pose, ticks)
    }

    /// Waits until the arm has come after.
    pub(super) fn settle(self) -> Self {
        self.wait(SETTLE)
    }

    /// Straight up to where bins are carried, and a little in any case.
    pub(super) fn lift(self) -> Self {
        let up = (self.setup.task.carry_height_m - self.at.position[2]).max(LEAST_LIFT_M);
        let pose = pose::shifted(&self.at, [0.0, 0.0, up]);
        self.to(pose)
    }

    /// To `pose`, around the arm where it stands in between.
    pub(super) fn around_to(self, pose: Pose) -> Self {
        let direction = |p: &Pose| libm::atan2(p.position[1], p.position[0]);
        let turn = (direction(&self.at) - direction(&pose)).abs();
        if turn < AROUND_RAD {
            return self.to(pose);
        }
        let task = &self.setup.task;
        let via = Pose {
            position: task.via_position_m,
            orientation_wxyz: straight_down(task.via_yaw_rad),
        };
        self.to(via).to(pose)
    }

    fn at_pace(self, pose: Pose, speed: f64) -> Self {
        let ticks = ticks_between(&self.at, &pose, speed, self.setup.task.turn_speed_rad_s);
        self.push(pose, ticks)
    }

    fn push(self, pose: Pose, ticks: u64) -> Self {
        let waypoint = Waypoint::new(pose).gliding(ticks);
        let waypoint = Waypoint {
            posture: self.lean,
            ..waypoint
        };
        self.put(waypoint)
    }

    fn put(mut self, waypoint: Waypoint) -> Self {
        let waypoint = waypoint.avoiding(self.obstacles, u64::MAX);
        if self.begun {
            // Ways are shorter than what fits; a waypoint too many would be one
            // corner cut.
            let _fits = self.motion.then(waypoint);
        } else {
            self.motion.go(waypoint, &self.at, self.now);
            self.begun = true;
        }
        self.at = waypoint.pose();
        self
    }
}

/// Time from one pose to another at `speed` (m/s) and `turn` (rad/s); ticks.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "lengths of ways divided by paces of the cell file: seconds, not negative"
)]
fn ticks_between(from: &Pose, to: &Pose, speed: f64, turn: f64) -> u64 {
    let (a, b) = (Vector3::from(from.position), Vector3::from(to.position));
    let (p, q) = (
        geometry::rotation(from.orientation_wxyz),
        geometry::rotation(to.orientation_wxyz),
    );
    let cosine = p.coords.dot(&q.coords).abs().min(1.0);
    let angle = 2.0 * libm::acos(cosine);
    let seconds = ((b - a).norm() / speed).max(angle / turn);
    (seconds * 1000.0).ceil() as u64
}

/// Where the arm waits.
pub(super) fn rest(setup: &BinStackSetup) -> Pose {
    Pose {
        position: setup.task.rest_position_m,
        // Four decimals, not quite a unit quaternion: the motion makes it one.
        orientation_wxyz: setup.task.rest_orientation_wxyz,
    }
}

/// Cup straight above the face of `bin` it is gripped on, `height` above it (m),
/// along the bin's sides as near to `yaw` as they allow.
pub(super) fn above(setup: &BinStackSetup, bin: &Bin, yaw: f64, height: f64) -> Pose {
    let below_centre = if bin.up() > 0.0 {
        // Open upward: the inner face of its floor.
        setup.wall_m - 0.5 * setup.height_m
    } else {
        0.5 * setup.height_m
    };
    let at = bin.pose.translation.vector;
    let position = [at.x, at.y, at.z + below_centre + height];
    Pose {
        position,
        orientation_wxyz: straight_down(along_sides(bin, yaw)),
    }
}

/// Direction of one of the bin's sides nearest to `yaw` (rad).
fn along_sides(bin: &Bin, yaw: f64) -> f64 {
    let side = bin.pose.rotation * Vector3::x();
    let direction = libm::atan2(side.y, side.x);
    let quarters = libm::round((yaw - direction) / std::f64::consts::FRAC_PI_2);
    direction + quarters * std::f64::consts::FRAC_PI_2
}

/// Direction of the arm's plane over `bin`: that of the belt for those before
/// the arm's left, of the holder or of the columns.
pub(super) fn yaw_over(setup: &BinStackSetup, bin: &Bin) -> f64 {
    let at = bin.pose.translation.vector;
    let task = &setup.task;
    let distance = |p: [f64; 3]| (Vector3::from(p) - at).xy().norm();
    let places = [
        (distance(task.belt_end_position_m), task.belt_yaw_rad),
        (distance(task.station.position_m), task.station.yaw_rad),
        (
            distance(
                setup
                    .columns
                    .centre(Slot {
                        column: 4,
                        level: 0,
                    })
                    .into(),
            ),
            task.stack.tool_yaw_rad,
        ),
    ];
    let nearest = places.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(0.0, |(_, yaw)| yaw)
}

/// Cup where the bin in it stands in `slot`, `gap` above its support (m): of the
/// two turns that are as good for the bin, the one nearer to the arm's plane.
pub(super) fn over_slot(setup: &BinStackSetup, slot: Slot, in_hand: &Pose, gap: f64) -> Pose {
    let goal = Translation3::new(0.0, 0.0, gap) * setup.columns.pose(slot);
    cup_for(&goal, in_hand, setup.columns.spec().tool_yaw_rad)
}

/// Cup where the bin in it lies upside down in the holder, `height` above the
/// rails (m) and `back` towards the arm (m).
pub(super) fn in_holder(setup: &BinStackSetup, in_hand: &Pose, height: f64, back: f64) -> Pose {
    let station = &setup.task.station;
    let [x, y, z] = station.position_m;
    let out = radial(station.yaw_rad);
    let centre = Vector3::new(x, y, z + height + 0.5 * setup.height_m) - out * back;
    // Long side across the rails.
    let across = station.yaw_rad + std::f64::consts::FRAC_PI_2;
    let yaw = UnitQuaternion::new_unchecked(half_turn_quaternion(Vector3::z(), across));
    let over =
        UnitQuaternion::new_unchecked(half_turn_quaternion(Vector3::x(), std::f64::consts::PI));
    let goal = Isometry3::from_parts(Translation3::from(centre), yaw * over);
    cup_for(&goal, in_hand, station.yaw_rad)
}

/// The cup's pose for a bin at `goal`, or at `goal` turned half about the
/// vertical: whichever has the frame's z axis nearer to `yaw`.
fn cup_for(goal: &Isometry3<f64>, in_hand: &Pose, yaw: f64) -> Pose {
    let grip = pose::isometry(in_hand).inverse();
    let half_turn =
        UnitQuaternion::new_unchecked(half_turn_quaternion(Vector3::z(), std::f64::consts::PI));
    let turned = Isometry3::from_parts(goal.translation, half_turn * goal.rotation);
    let along = |cup: &Isometry3<f64>| (cup.rotation * Vector3::z()).dot(&radial(yaw));
    let (one, other) = (goal * grip, turned * grip);
    pose::wire(if along(&one) >= along(&other) {
        &one
    } else {
        &other
    })
}

/// Poses of turning over at the flipping station.
pub(super) struct Turning {
    /// Cup pointing down.
    pub(super) down: Pose,
    /// Cup pointing up.
    pub(super) up: Pose,
}

/// Before and after half a turn of the wrist.
pub(super) fn turning(setup: &BinStackSetup) -> Turning {
    let station = &setup.task.station;
    let out = radial(station.yaw_rad);
    let up = Vector3::z();
    let axis =
        Vector3::from(station.position_m) - out * station.slide_m + up * station.turn_height_m;
    let at = |direction: Vector3<f64>| Pose {
        position: (axis + direction * station.turn_radius_m).into(),
        orientation_wxyz: pose::pointing(direction, out),
    };
    Turning {
        down: at(-up),
        up: at(up),
    }
}

/// The cup pushed down out of a bin in the holder, from where it let go.
pub(super) fn pushed_down(setup: &BinStackSetup, from: &Pose) -> Pose {
    pose::shifted(from, [0.0, 0.0, -setup.task.station.push_down_m])
}

/// The cup moved towards the arm, out from under the holder.
pub(super) fn moved_back(setup: &BinStackSetup, from: &Pose) -> Pose {
    let back = radial(setup.task.station.yaw_rad) * -setup.task.station.slide_m;
    pose::shifted(from, back.into())
}

/// Whether the cup points up: then it is at the flipping station, or was led there.
pub(super) fn points_up(tcp: &Pose) -> bool {
    approach(tcp).z > 0.3
}

fn radial(yaw: f64) -> Vector3<f64> {
    Vector3::new(libm::cos(yaw), libm::sin(yaw), 0.0)
}
