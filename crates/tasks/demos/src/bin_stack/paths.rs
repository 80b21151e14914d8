//! Poses of the TCP along the routes of a bin.

use std::f64::consts::{FRAC_PI_2, PI};

use ipc_types::Pose;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use robocell_skills::geometry::{nearest_quarter, straight_down_by_x as straight_down};
use robocell_skills::matrix::{Spot, pick};
use robocell_skills::path::Route;
use robocell_skills::pose;

use super::columns::Slot;
use super::job::BinStack;
use super::scene::{Bin, View};

/// Within this distance of the holder a cup that points up is at the flipping station (m): it
/// has to leave the holder downwards.
const AT_HOLDER_M: f64 = 0.5;

/// A route to `pose`, around the arm where the arm is in between.
pub(super) fn around_to<'r>(view: View<'_>, route: Route<'r>, pose: Pose) -> Route<'r> {
    let task = &view.of.task;
    let via = Pose {
        position: task.via_position_m,
        orientation_wxyz: straight_down(task.via_yaw_rad),
    };
    route.around_to(view.of.base, view.own.around_rad, via, pose)
}

/// How a route of a bin, or of the empty cup, starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begin {
    /// The arm is where the job brought it.
    Directly,
    /// The operator led the arm, or it did not arrive: its joints go to their start positions
    /// first.
    Restoring,
}

/// The spot at which `bin` is gripped from above, turned along its sides as near to the arm's
/// plane as they allow, and with it where it leans. The holder does not count as an obstacle for a bin in it.
pub(super) fn spot(view: View<'_>, bin: &Bin) -> Spot {
    let of = view.of;
    let below_centre = if bin.up() > 0.0 {
        // Open upward: the inner face of its floor.
        of.wall_m - 0.5 * of.height_m
    } else {
        0.5 * of.height_m
    };
    let at = bin.pose.translation.vector;
    let side = bin.pose.rotation * Vector3::x();
    // A quarter turn of the bin looks the same to the cup; the nearest one turns the wrist
    // least and keeps its joint from winding up.
    let yaw = nearest_quarter(libm::atan2(side.y, side.x), yaw_over(view, bin));
    let level = Pose {
        position: [at.x, at.y, at.z + below_centre],
        orientation_wxyz: straight_down(yaw),
    };
    Spot {
        at: if view.is_flat(bin) {
            level
        } else {
            leaning(&level, bin)
        },
        obstacles: obstacles(view, bin),
        at_rest: bin.at_rest,
    }
}

/// The pose at a bin that leans, from that at a level one.
fn leaning(level: &Pose, bin: &Bin) -> Pose {
    let up = bin.pose.rotation * Vector3::z() * bin.up().signum();
    let tilt = UnitQuaternion::rotation_between(&Vector3::z(), &up);
    let about = bin.pose.translation;
    let turned = about * tilt.unwrap_or_else(UnitQuaternion::identity) * about.inverse();
    pose::wire(&(turned * pose::isometry(level)))
}

/// Pose of the TCP above the spot at which `bin` is gripped.
pub(super) fn above(view: View<'_>, bin: &Bin) -> Pose {
    pick::above(view.of, &spot(view, bin))
}

/// Obstacles of a route that starts or ends at `bin`, which may be in the holder.
pub(super) fn obstacles(view: View<'_>, bin: &Bin) -> u64 {
    let holder = Vector3::from(view.of.task.station.position_m);
    let in_holder = (bin.pose.translation.vector - holder).norm() < view.own.holder_m;
    if in_holder {
        view.of.without_holder
    } else {
        u64::MAX
    }
}

/// Direction of the arm's plane over `bin`: that of the nearest of belt, holder and columns.
fn yaw_over(view: View<'_>, bin: &Bin) -> f64 {
    let of = view.of;
    let at = bin.pose.translation.vector;
    let task = &of.task;
    let distance = |p: [f64; 3]| (Vector3::from(p) - at).xy().norm();
    let places = [
        (distance(task.belt_end_position_m), task.belt_yaw_rad),
        (distance(task.station.position_m), task.station.yaw_rad),
        (
            distance(of.columns.middle().into()),
            task.stack.tool_yaw_rad,
        ),
    ];
    let nearest = places.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(0.0, |(_, yaw)| yaw)
}

/// Pose of the cup with its bin in `slot`, `gap` above the support (m). A bin may be turned by
/// half a turn, so the pose nearer to the arm's plane is chosen.
pub(super) fn over_slot(view: View<'_>, slot: Slot, in_hand: &Pose, gap: f64) -> Pose {
    let mut goal = view.of.columns.pose(&view.own.order, slot);
    goal.translation.vector.z += gap;
    cup_for(&goal, in_hand, view.of.task.stack.tool_yaw_rad)
}

/// Pose of the cup with its bin upside down in the holder, `height` above the rails (m) and
/// `back` towards the arm (m).
pub(super) fn in_holder(of: &BinStack, in_hand: &Pose, height: f64, back: f64) -> Pose {
    let station = &of.task.station;
    let [x, y, z] = station.position_m;
    let out = radial(station.yaw_rad);
    let centre = Vector3::new(x, y, z + height + 0.5 * of.height_m) - out * back;
    // The long side is across the rails: its rim rests on both.
    let yaw = pose::about(Vector3::z(), station.yaw_rad + FRAC_PI_2);
    let over = pose::about(Vector3::x(), PI);
    let goal = Isometry3::from_parts(centre.into(), yaw * over);
    cup_for(&goal, in_hand, station.yaw_rad)
}

/// The cup's pose for a bin at `goal`, or at `goal` after half a turn about the vertical: the
/// one whose z axis is nearer to the direction `yaw`.
fn cup_for(goal: &Isometry3<f64>, in_hand: &Pose, yaw: f64) -> Pose {
    let grip = pose::isometry(in_hand).inverse();
    let half_turn = pose::about(Vector3::z(), PI);
    let turned = Isometry3::from_parts(goal.translation, half_turn * goal.rotation);
    let along = |cup: &Isometry3<f64>| (cup.rotation * Vector3::z()).dot(&radial(yaw));
    let (one, other) = (goal * grip, turned * grip);
    pose::wire(if along(&one) >= along(&other) {
        &one
    } else {
        &other
    })
}

/// Poses of the cup for turning a bin over at the flipping station.
pub(super) struct Turning {
    /// Cup pointing down.
    pub(super) down: Pose,
    /// Cup pointing up.
    pub(super) up: Pose,
}

/// The poses before and after half a turn of the wrist.
pub(super) fn turning(of: &BinStack) -> Turning {
    let station = &of.task.station;
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

/// The cup pushed down out of a bin in the holder, from the pose of the release.
pub(super) fn pushed_down(of: &BinStack, from: &Pose) -> Pose {
    pose::shifted(from, [0.0, 0.0, -of.task.station.push_down_m])
}

/// The cup moved towards the arm, away from below the holder.
pub(super) fn moved_back(of: &BinStack, from: &Pose) -> Pose {
    let back = radial(of.task.station.yaw_rad) * -of.task.station.slide_m;
    pose::shifted(from, back.into())
}

/// Whether the cup points up: at the flipping station, or led there by an operator.
pub(super) fn points_up(tcp: &Pose) -> bool {
    pose::approach(tcp).z > 0.3
}

/// Whether the cup points up at the flipping station.
pub(super) fn is_in_holder(of: &BinStack, tcp: &Pose) -> bool {
    let off = Vector3::from(tcp.position) - Vector3::from(of.task.station.position_m);
    points_up(tcp) && off.norm() < AT_HOLDER_M
}

fn radial(yaw: f64) -> Vector3<f64> {
    Vector3::new(libm::cos(yaw), libm::sin(yaw), 0.0)
}
