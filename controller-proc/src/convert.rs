//! Conversion between poses of messages and poses for calculation.

use ipc_types::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

/// A pose for calculation. The orientation was validated to be of norm 1.
pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.position;
    let [w, i, j, k] = pose.orientation_wxyz;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)),
    )
}

/// A pose for a message.
pub(crate) fn pose(isometry: &Isometry3<f64>) -> Pose {
    let r = isometry.rotation;
    Pose {
        position: isometry.translation.vector.into(),
        orientation_wxyz: [r.w, r.i, r.j, r.k],
    }
}

/// Angle between two orientations (rad).
// By atan2: the arc cosine of the scalar part loses half of the digits at small angles.
pub(crate) fn angle(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    let difference = a.inverse() * b;
    2.0 * libm::atan2(difference.imag().norm(), difference.scalar().abs())
}
