//! How a bin is held under the dispenser.

use ipc_types::Pose;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::grasp::Side;
use super::scene::View;
use robocell_skills::{geometry, pose};

/// Cosine of the angle up to which a bin counts as opening upward or a cup as
/// pointing along a side of it: 30 degrees.
const ABOUT: f64 = 0.866;

/// Which side of the bin the cup holds, as it is seen.
pub(super) fn side(scene: &View<'_, '_>) -> Side {
    let up = scene.up().dot(&pose::approach(&scene.tcp));
    if up < -0.7 {
        Side::Floor
    } else if up > 0.7 {
        Side::Bottom
    } else {
        Side::Wall
    }
}

/// Whether parts would fall into the bin as it is held.
pub(super) fn opens_up(scene: &View<'_, '_>) -> bool {
    scene.up().z > ABOUT
}

/// The cup over the hold position, pointing down, with the bin's long edge turned
/// as the dispenser wants it: how every bin hangs at first.
pub(super) fn hanging(scene: &View<'_, '_>) -> Pose {
    let task = &scene.setup.task;
    let tcp = pose::isometry(&scene.tcp);
    let down = geometry::rotation(scene.tcp.orientation_wxyz) * Vector3::x();
    let upright = UnitQuaternion::rotation_between(&down, &-Vector3::z())
        .unwrap_or_else(UnitQuaternion::identity);
    let bin = upright * scene.bin.rotation;
    // The edge that lies flattest of the two long enough to tell.
    let (long, short) = (bin * Vector3::x(), bin * Vector3::y());
    let edge = if long.z.abs() < short.z.abs() {
        long
    } else {
        short.cross(&Vector3::z())
    };
    let turn = half_turn(task.hold_yaw_rad - libm::atan2(edge.y, edge.x));
    Pose {
        position: task.hold_position_m,
        orientation_wxyz: pose::wxyz(&(about_z(turn) * upright * tcp.rotation)),
    }
}

/// The cup beside a bin that it holds by a wall, pointing as in the source along
/// -x, so that the bin opens upward under the dispenser. `None` where the cup
/// holds it otherwise.
pub(super) fn upright(scene: &View<'_, '_>) -> Option<Pose> {
    let setup = scene.setup;
    if side(scene) != Side::Wall {
        return None;
    }
    let tcp_in_bin = scene.bin.inverse() * pose::isometry(&scene.tcp);
    let inward = tcp_in_bin.rotation * Vector3::x();
    // The turn of an upright bin that lets the cup point along -x.
    let turn = std::f64::consts::PI - libm::atan2(inward.y, inward.x);
    let [x, y, z] = setup.task.hold_position_m;
    let height = z + 0.5 * setup.size.z - setup.wall_m;
    let bin = Isometry3::from_parts(Translation3::new(x, y, height), about_z(turn));
    Some(pose::wire(&(bin * tcp_in_bin)))
}

fn about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    UnitQuaternion::new_normalize(nalgebra::Quaternion::new(cos, 0.0, 0.0, sin))
}

/// The angle equal to `angle` up to half turns that is nearest to none (rad).
fn half_turn(angle: f64) -> f64 {
    let half = std::f64::consts::PI;
    angle - (angle / half).round() * half
}
