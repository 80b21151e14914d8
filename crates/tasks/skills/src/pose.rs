//! Calculations with poses, and a pose in a checkpoint. The approach axis of a suction cup is
//! its frame's x axis. Quaternions are w x y z.

use ipc_types::Pose;
use ipc_types::validate::MAX_POSITION_M;
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::geometry::rotation;

/// Tolerance of the norm of a quaternion from a cell file, which has four decimals.
const UNIT: f64 = 1.0e-4;

/// A pose as plain data, for a checkpoint; the field that has it names the frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptPose {
    /// Position (m).
    pub position: [f64; 3],
    /// Unit quaternion, w x y z.
    pub orientation_wxyz: [f64; 4],
}

impl KeptPose {
    /// The pose for calculations.
    pub fn isometry(&self) -> Isometry3<f64> {
        isometry(&(*self).into())
    }

    /// Whether a restored pose is valid: a position in a cell, a unit quaternion.
    pub fn is_sound(&self) -> bool {
        let norm = nalgebra::Vector4::from(self.orientation_wxyz).norm();
        within(&self.position, MAX_POSITION_M) && (norm - 1.0).abs() <= UNIT
    }
}

impl From<Pose> for KeptPose {
    fn from(pose: Pose) -> Self {
        Self {
            position: pose.position,
            orientation_wxyz: pose.orientation_wxyz,
        }
    }
}

impl From<&Isometry3<f64>> for KeptPose {
    fn from(at: &Isometry3<f64>) -> Self {
        wire(at).into()
    }
}

impl From<KeptPose> for Pose {
    fn from(kept: KeptPose) -> Self {
        with_unit_quaternion(&Self {
            position: kept.position,
            orientation_wxyz: kept.orientation_wxyz,
        })
    }
}

/// Whether restored numbers are finite and at most `limit`.
pub fn within(values: &[f64], limit: f64) -> bool {
    // NaN is not at most anything, so it is refused as well.
    values.iter().all(|value| value.abs() <= limit)
}

/// A rotation as a quaternion w x y z.
pub fn wxyz(rotation: &UnitQuaternion<f64>) -> [f64; 4] {
    [rotation.w, rotation.i, rotation.j, rotation.k]
}

/// The pose with a unit quaternion, as messages require it: that of a cell file has four
/// decimals. A unit quaternion keeps its bits.
pub fn with_unit_quaternion(pose: &Pose) -> Pose {
    let norm = nalgebra::Vector4::from(pose.orientation_wxyz).norm();
    // Without this a pose would change in its last bit with each copy, and with it the state
    // hash.
    if (norm - 1.0).abs() < 1.0e-9 {
        return *pose;
    }
    Pose {
        orientation_wxyz: wxyz(&rotation(pose.orientation_wxyz)),
        ..*pose
    }
}

/// A pose for calculations.
pub fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.position;
    Isometry3::from_parts(Translation3::new(x, y, z), rotation(pose.orientation_wxyz))
}

/// A pose in the form of messages.
pub fn wire(pose: &Isometry3<f64>) -> Pose {
    Pose {
        position: pose.translation.vector.into(),
        orientation_wxyz: wxyz(&pose.rotation),
    }
}

/// A turn about a unit `axis` (rad). Sine and cosine are those of `libm`, which are the same on
/// every machine.
pub fn about(axis: Vector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    let turn = nalgebra::Quaternion::new(cos, axis.x * sin, axis.y * sin, axis.z * sin);
    UnitQuaternion::new_unchecked(turn)
}

/// Distance of two positions (m).
pub fn distance(a: &Pose, b: &Pose) -> f64 {
    (Vector3::from(a.position) - Vector3::from(b.position)).norm()
}

/// The direction of the cup: the x axis of its frame.
pub fn approach(pose: &Pose) -> Vector3<f64> {
    rotation(pose.orientation_wxyz) * Vector3::x()
}

/// The pose moved by `distance` along its own x axis (m); negative moves it back.
pub fn along_approach(pose: &Pose, distance: f64) -> Pose {
    let moved = Vector3::from(pose.position) + approach(pose) * distance;
    Pose {
        position: moved.into(),
        ..*pose
    }
}

/// The pose moved by `offset` in the world frame (m).
pub fn shifted(pose: &Pose, offset: [f64; 3]) -> Pose {
    let moved = Vector3::from(pose.position) + Vector3::from(offset);
    Pose {
        position: moved.into(),
        ..*pose
    }
}

/// Orientation (w x y z) of a cup that points along `approach`, with the frame's z axis as near
/// to `up` as possible. If the two are parallel, any turn about the approach is valid.
pub fn pointing(approach: Vector3<f64>, up: Vector3<f64>) -> [f64; 4] {
    let x = approach
        .try_normalize(1.0e-9)
        .unwrap_or_else(|| -Vector3::z());
    // An axis that is surely not parallel to the approach.
    let spare = if x.x.abs() < 0.9 {
        Vector3::x()
    } else {
        Vector3::y()
    };
    let off_axis = |v: Vector3<f64>| (v - x * v.dot(&x)).try_normalize(1.0e-6);
    let z = off_axis(up)
        .or_else(|| off_axis(spare))
        .unwrap_or_else(Vector3::z);
    let axes = nalgebra::Matrix3::from_columns(&[x, z.cross(&x), z]);
    wxyz(&UnitQuaternion::from_matrix(&axes))
}

/// The pose at `part` of the way from `from` to `to`, 0 to 1, turned the short way about one
/// axis.
pub fn between(from: &Pose, to: &Pose, part: f64) -> Pose {
    let (a, b) = (Vector3::from(from.position), Vector3::from(to.position));
    let (p, q) = (
        rotation(from.orientation_wxyz),
        rotation(to.orientation_wxyz),
    );
    Pose {
        position: (a + (b - a) * part).into(),
        orientation_wxyz: wxyz(&slerp(&p, &q, part)),
    }
}

/// Interpolation with sine and arc cosine that are the same everywhere (`libm`).
fn slerp(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, part: f64) -> UnitQuaternion<f64> {
    let (p, mut q) = (*from.quaternion(), *to.quaternion());
    let mut cosine = p.dot(&q);
    // The same rotation with the other sign: the short way round.
    if cosine < 0.0 {
        (q, cosine) = (-q, -cosine);
    }
    // Nearly equal rotations: the division by the sine would lose all digits, a straight line
    // is exact.
    let (a, b) = if cosine > 0.9995 {
        (1.0 - part, part)
    } else {
        let angle = libm::acos(cosine);
        let whole = libm::sin(angle);
        let share = |part: f64| libm::sin(part * angle) / whole;
        (share(1.0 - part), share(part))
    };
    Unit::new_normalize(p * a + q * b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::straight_down_by_x as straight_down;

    fn near(a: Vector3<f64>, b: [f64; 3]) {
        assert!((a - Vector3::from(b)).norm() < 1.0e-12, "{a} {b:?}");
    }

    fn at(orientation_wxyz: [f64; 4]) -> Pose {
        Pose {
            position: [1.0, 2.0, 3.0],
            orientation_wxyz,
        }
    }

    #[test]
    fn a_cup_that_points_down_backs_off_upward() {
        for yaw in [0.0, 1.0, -2.5] {
            let pose = at(straight_down(yaw));
            near(approach(&pose), [0.0, 0.0, -1.0]);
            let off = along_approach(&pose, -0.25).position;
            near(off.into(), [1.0, 2.0, 3.25]);
            let z = rotation(pose.orientation_wxyz) * Vector3::z();
            near(z, [libm::cos(yaw), libm::sin(yaw), 0.0]);
        }
    }

    #[test]
    fn a_cup_points_where_it_is_told_with_z_up() {
        let q = rotation(pointing(Vector3::new(-1.0, 0.0, 0.0), Vector3::z()));
        near(q * Vector3::x(), [-1.0, 0.0, 0.0]);
        near(q * Vector3::z(), [0.0, 0.0, 1.0]);
        // Parallel to the wish, and nonsense: still an orientation.
        let q = rotation(pointing(Vector3::z(), Vector3::z()));
        near(q * Vector3::x(), [0.0, 0.0, 1.0]);
        let q = rotation(pointing(Vector3::zeros(), Vector3::zeros()));
        near(q * Vector3::x(), [0.0, 0.0, -1.0]);
    }

    #[test]
    fn an_orientation_of_a_cell_file_points_forward_and_down() {
        let pose = at([0.6234, -0.3342, 0.3339, 0.6231]);
        let along = approach(&pose);
        assert!((along - Vector3::new(0.001, 0.554, -0.833)).norm() < 2.0e-3);
    }

    #[test]
    fn halfway_is_halfway_the_short_way() {
        let (from, to) = (at(straight_down(0.2)), at(straight_down(1.0)));
        let (q, flipped) = (to.orientation_wxyz, to.orientation_wxyz.map(|x| -x));
        for target in [q, flipped] {
            let middle = between(&from, &at(target), 0.5);
            let wanted = rotation(straight_down(0.6));
            assert!(rotation(middle.orientation_wxyz).angle_to(&wanted) < 1.0e-9);
        }
        assert_eq!(isometry(&wire(&isometry(&from))), isometry(&from));
    }

    #[test]
    fn what_is_no_pose_is_not_sound() {
        let kept = KeptPose::from(Pose::IDENTITY);
        assert!(kept.is_sound());
        let at = |position| KeptPose { position, ..kept };
        assert!(!at([0.0, f64::NAN, 0.0]).is_sound());
        assert!(!at([0.0, 0.0, -1.0e4]).is_sound());
        let turned = |orientation_wxyz| KeptPose {
            orientation_wxyz,
            ..kept
        };
        assert!(!turned([0.0; 4]).is_sound());
        assert!(!turned([f64::INFINITY, 0.0, 0.0, 0.0]).is_sound());
    }
}
