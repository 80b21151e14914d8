//! Turns about the vertical axis, and distances.

use std::f64::consts::FRAC_PI_2;

use ipc_types::Pose;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector2, Vector3};

/// Turn of a cuboid about the vertical axis, -45 to 45 degrees (rad): a quarter turn makes no
/// difference. It is read from the body axis nearest to the horizontal plane, so it is defined
/// for a cuboid on its side, too.
pub fn yaw(pose: &Pose) -> f64 {
    let rotation = rotation(pose.orientation_wxyz);
    let mut flattest = rotation * Vector3::x();
    for axis in [rotation * Vector3::y(), rotation * Vector3::z()] {
        if axis.z.abs() < flattest.z.abs() {
            flattest = axis;
        }
    }
    nearest_quarter(libm::atan2(flattest.y, flattest.x), 0.0)
}

/// Turn of a tool about the vertical axis (rad): the direction of its x axis.
pub fn tool_yaw(tcp: &Pose) -> f64 {
    let axis = rotation(tcp.orientation_wxyz) * Vector3::x();
    libm::atan2(axis.y, axis.x)
}

/// The angle nearest to `reference` that differs from `angle` by quarter turns (rad).
pub fn nearest_quarter(angle: f64, reference: f64) -> f64 {
    angle - ((angle - reference) / FRAC_PI_2).round() * FRAC_PI_2
}

/// Orientation (w x y z) of a tool whose z axis points straight down, turned by `yaw` about the
/// vertical axis (rad). Without a turn it is (0, 1, 0, 0), and two fingers close along the
/// world's y axis.
pub fn straight_down(yaw: f64) -> [f64; 4] {
    [0.0, libm::cos(yaw / 2.0), libm::sin(yaw / 2.0), 0.0]
}

/// Orientation (w x y z) of a tool whose x axis points straight down, turned by `yaw` about the
/// vertical axis (rad). Without a turn the tool's z axis is parallel to the world's x axis.
pub fn straight_down_by_x(yaw: f64) -> [f64; 4] {
    let half = 0.5 * yaw;
    let turn = Quaternion::new(libm::cos(half), 0.0, 0.0, libm::sin(half));
    // A quarter turn about y maps x to -z, and z to x.
    let h = std::f64::consts::FRAC_1_SQRT_2;
    let down = Unit::new_normalize(turn * Quaternion::new(h, 0.0, h, 0.0));
    [down.w, down.i, down.j, down.k]
}

/// Angle between two orientations (rad), 0 to pi.
pub fn angle_between(a: [f64; 4], b: [f64; 4]) -> f64 {
    let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    // The absolute value: q and -q are one rotation. The clamp: rounding may give
    // 1.0000000000000002, whose arc cosine is NaN.
    2.0 * libm::acos(dot.abs().min(1.0))
}

/// Distance in the horizontal plane (m).
pub fn plane_distance(a: Vector3<f64>, b: Vector3<f64>) -> f64 {
    (a.xy() - b.xy()).norm()
}

/// `offset` turned by `angle` (rad) in the plane.
pub fn turned(offset: Vector2<f64>, angle: f64) -> Vector2<f64> {
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    Vector2::new(
        cos * offset.x - sin * offset.y,
        sin * offset.x + cos * offset.y,
    )
}

/// The rotation of a quaternion w x y z, normalised.
pub fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose(rotation: UnitQuaternion<f64>) -> Pose {
        let q = rotation.quaternion();
        Pose {
            position: [0.0; 3],
            orientation_wxyz: [q.w, q.i, q.j, q.k],
        }
    }

    #[test]
    fn yaw_is_the_same_on_every_side_of_a_cube() {
        for degrees in [-44.0_f64, -10.0, 0.0, 3.0, 44.0] {
            let yaw_rad = degrees.to_radians();
            for (roll, pitch, turns) in [
                (0.0, 0.0, 0.0),
                (1.0, 0.0, 1.0),
                (0.0, 1.0, 2.0),
                (2.0, 1.0, 3.0),
            ] {
                let turned =
                    UnitQuaternion::from_euler_angles(0.0, 0.0, yaw_rad + turns * FRAC_PI_2);
                let on_a_side =
                    UnitQuaternion::from_euler_angles(roll * FRAC_PI_2, pitch * FRAC_PI_2, 0.0);
                let seen = yaw(&pose(turned * on_a_side));
                assert!((seen - yaw_rad).abs() < 1e-9, "{degrees} deg: {seen}");
            }
        }
    }

    #[test]
    fn a_quarter_is_chosen_near_the_reference() {
        assert!((nearest_quarter(0.9, 0.0) - (0.9 - FRAC_PI_2)).abs() < 1e-12);
        assert!((nearest_quarter(0.9, 0.7) - 0.9).abs() < 1e-12);
        assert!((nearest_quarter(-0.1, FRAC_PI_2) - (FRAC_PI_2 - 0.1)).abs() < 1e-12);
    }

    #[test]
    fn the_tool_points_down_whatever_the_yaw() {
        assert_eq!(straight_down(0.0), [0.0, 1.0, 0.0, 0.0]);
        for yaw in [0.0, 0.3, -2.0] {
            let by_z = rotation(straight_down(yaw));
            assert!((by_z * Vector3::z() + Vector3::z()).norm() < 1e-12);
            assert!((tool_yaw(&pose(by_z)) - yaw).abs() < 1e-12);
            let by_x = rotation(straight_down_by_x(yaw));
            assert!((by_x * Vector3::x() + Vector3::z()).norm() < 1e-12);
            let z = by_x * Vector3::z();
            assert!((libm::atan2(z.y, z.x) - yaw).abs() < 1e-12);
        }
        assert!((angle_between(straight_down(0.0), straight_down(0.3)) - 0.3).abs() < 1e-9);
        let quarter = turned(Vector2::new(1.0, 0.0), FRAC_PI_2);
        assert!((quarter - Vector2::new(0.0, 1.0)).norm() < 1e-12);
    }
}
