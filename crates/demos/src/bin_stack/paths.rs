//! Poses of the TCP on the ways of a bin.

use std::f64::consts::{FRAC_PI_2, PI};

use ipc_types::Pose;
use nalgebra::{Isometry3, Vector3};
use robocell_skills::geometry::{nearest_quarter, straight_down_by_x as straight_down};
use robocell_skills::matrix::{Spot, pick};
use robocell_skills::path::Route;
use robocell_skills::pose;

use super::columns::Slot;
use super::job::BinStack;
use super::scene::{Bin, View};

/// The cup leaves the holder downwards where it is this near to it (m).
const AT_HOLDER_M: f64 = 0.5;

/// To `pose`, around the arm where that is in between.
pub(super) fn around_to<'r>(view: View<'_>, route: Route<'r>, pose: Pose) -> Route<'r> {
    let task = &view.of.task;
    let via = Pose {
        position: task.via_position_m,
        orientation_wxyz: straight_down(task.via_yaw_rad),
    };
    route.around_to(view.of.base, view.own.around_rad, via, pose)
}

/// The way a bin, or the empty cup, begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Begin {
    /// The arm is where the job brought it.
    Directly,
    /// The operator led the arm, or it did not arrive: its joints go to their positions
    /// at the start first.
    Restoring,
}

/// Where `bin` is gripped from above, along its sides as near to the arm's plane as
/// they allow. The holder is no obstacle for a bin in it.
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
    let yaw = nearest_quarter(libm::atan2(side.y, side.x), yaw_over(view, bin));
    Spot {
        at: Pose {
            position: [at.x, at.y, at.z + below_centre],
            orientation_wxyz: straight_down(yaw),
        },
        obstacles: obstacles(view, bin),
        at_rest: bin.at_rest,
    }
}

/// The TCP above where `bin` is gripped.
pub(super) fn above(view: View<'_>, bin: &Bin) -> Pose {
    pick::above(view.of, &spot(view, bin))
}

/// Obstacles for a way that begins or ends at `bin`, which may be in the holder.
pub(super) fn obstacles(view: View<'_>, bin: &Bin) -> u64 {
    let holder = Vector3::from(view.of.task.station.position_m);
    let in_holder = (bin.pose.translation.vector - holder).norm() < view.own.holder_m;
    if in_holder {
        view.of.without_holder
    } else {
        u64::MAX
    }
}

/// Direction of the arm's plane over `bin`: that of the belt for those before
/// the arm's left, of the holder or of the columns.
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

/// Cup where the bin in it is in `slot`, `gap` above its support (m): of the
/// two turns that are as good for the bin, the one nearer to the arm's plane.
pub(super) fn over_slot(view: View<'_>, slot: Slot, in_hand: &Pose, gap: f64) -> Pose {
    let mut goal = view.of.columns.pose(&view.own.order, slot);
    goal.translation.vector.z += gap;
    cup_for(&goal, in_hand, view.of.task.stack.tool_yaw_rad)
}

/// Cup where the bin in it is upside down in the holder, `height` above the
/// rails (m) and `back` towards the arm (m).
pub(super) fn in_holder(of: &BinStack, in_hand: &Pose, height: f64, back: f64) -> Pose {
    let station = &of.task.station;
    let [x, y, z] = station.position_m;
    let out = radial(station.yaw_rad);
    let centre = Vector3::new(x, y, z + height + 0.5 * of.height_m) - out * back;
    // Long side across the rails.
    let yaw = pose::about(Vector3::z(), station.yaw_rad + FRAC_PI_2);
    let over = pose::about(Vector3::x(), PI);
    let goal = Isometry3::from_parts(centre.into(), yaw * over);
    cup_for(&goal, in_hand, station.yaw_rad)
}

/// The cup's pose for a bin at `goal`, or at `goal` turned half about the
/// vertical: whichever has the frame's z axis nearer to `yaw`.
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

/// Poses of turning over at the flipping station.
pub(super) struct Turning {
    /// Cup pointing down.
    pub(super) down: Pose,
    /// Cup pointing up.
    pub(super) up: Pose,
}

/// Before and after half a turn of the wrist.
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

/// The cup pushed down out of a bin in the holder, from where it let go.
pub(super) fn pushed_down(of: &BinStack, from: &Pose) -> Pose {
    pose::shifted(from, [0.0, 0.0, -of.task.station.push_down_m])
}

/// The cup moved towards the arm, out from under the holder.
pub(super) fn moved_back(of: &BinStack, from: &Pose) -> Pose {
    let back = radial(of.task.station.yaw_rad) * -of.task.station.slide_m;
    pose::shifted(from, back.into())
}

/// Whether the cup points up: then it is at the flipping station, or was led there.
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
