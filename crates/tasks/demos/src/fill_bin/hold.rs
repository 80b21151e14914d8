//! Poses of a bin under the dispenser.

use ipc_types::Pose;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::job::Turn;
use robocell_skills::{geometry, pose};

/// A bin that is upside down is turned by this before it is dropped (rad).
// Dropped level it comes to rest as it was, and from a quarter turn now and then. From here, as
// from 1.9 and 2.5, it falls on the edge below its opening.
const TIP_RAD: f64 = 2.2;

/// Pose of the bin, and the direction in which it opens.
fn bin(turn: &Turn<'_>) -> (Isometry3<f64>, Vector3<f64>) {
    let bin = turn.seen(turn.of.bin);
    let bin = bin.map_or_else(Isometry3::identity, |bin| bin.pose);
    (bin, bin.rotation * Vector3::z())
}

/// Whether parts fall into the bin as it is held.
pub(super) fn opens_up(turn: &Turn<'_>) -> bool {
    bin(turn).1.z > turn.own.opens_up
}

/// The cup over the hold position, pointing down, with the bin's long edge in the direction
/// that the dispenser needs: the first pose of every bin.
pub(super) fn hanging(turn: &Turn<'_>) -> Pose {
    let task = &turn.of.task;
    let tcp = pose::isometry(&turn.tcp);
    // The tilt of the cup is removed from the bin, too: its edges are compared as it will hang.
    let down = geometry::rotation(turn.tcp.orientation_wxyz) * Vector3::x();
    let upright = UnitQuaternion::rotation_between(&down, &-Vector3::z())
        .unwrap_or_else(UnitQuaternion::identity);
    let bin = upright * bin(turn).0.rotation;
    // The more level of the two edges: the direction of a steep one is not defined in the
    // plane.
    let (long, short) = (bin * Vector3::x(), bin * Vector3::y());
    let edge = if long.z.abs() < short.z.abs() {
        long
    } else {
        short.cross(&Vector3::z())
    };
    let yaw = half_turn(task.hold_yaw_rad - libm::atan2(edge.y, edge.x));
    Pose {
        position: task.hold_position_m,
        orientation_wxyz: pose::wxyz(&(pose::about(Vector3::z(), yaw) * upright * tcp.rotation)),
    }
}

/// The cup beside a bin that it holds by a wall, pointing along -x, so that the bin opens
/// upward under the dispenser. `None` if the cup holds the bin at another side.
pub(super) fn upright(turn: &Turn<'_>) -> Option<Pose> {
    let of = turn.of;
    let (bin, up) = bin(turn);
    if up.dot(&pose::approach(&turn.tcp)).abs() > turn.own.facing {
        return None;
    }
    let tcp_in_bin = bin.inverse() * pose::isometry(&turn.tcp);
    let inward = tcp_in_bin.rotation * Vector3::x();
    // The turn of an upright bin that makes the cup point along -x.
    let yaw = std::f64::consts::PI - libm::atan2(inward.y, inward.x);
    let [x, y, z] = of.task.hold_position_m;
    let height = z + 0.5 * of.size.z - of.wall_m;
    let bin = Isometry3::from_parts(
        Translation3::new(x, y, height),
        pose::about(Vector3::z(), yaw),
    );
    Some(pose::wire(&(bin * tcp_in_bin)))
}

/// A bin that hangs upside down from `hold`, moved by `aside` (m) and turned by [`TIP_RAD`].
pub(super) fn on_its_side(hold: &Pose, aside: [f64; 3]) -> Pose {
    let turned = pose::about(Vector3::y(), TIP_RAD) * pose::isometry(hold).rotation;
    Pose {
        orientation_wxyz: pose::wxyz(&turned),
        ..pose::shifted(hold, aside)
    }
}

/// The angle nearest to zero that differs from `angle` by half turns (rad).
fn half_turn(angle: f64) -> f64 {
    let half = std::f64::consts::PI;
    angle - (angle / half).round() * half
}
