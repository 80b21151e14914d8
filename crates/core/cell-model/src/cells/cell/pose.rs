//! Poses of a cell file.

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion};

/// Pose at a position (m), turned about z (rad).
pub(super) fn pose([x, y, z]: [f64; 3], yaw_rad: f64) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, z), turn_about_z(yaw_rad))
}

/// Pose at a position (m), turned about z (rad), or with the orientation w x y z of a file, whose
/// norm was checked.
pub(super) fn oriented(position: [f64; 3], yaw_rad: f64, wxyz: Option<[f64; 4]>) -> Isometry3<f64> {
    let turned = pose(position, yaw_rad);
    let Some([w, x, y, z]) = wxyz else {
        return turned;
    };
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    Isometry3::from_parts(turned.translation, rotation)
}

/// A turn about z (rad), with sine and cosine of `libm`, which are the same on every machine.
pub fn turn_about_z(angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = (libm::sin(0.5 * angle), libm::cos(0.5 * angle));
    Unit::new_unchecked(nalgebra::Quaternion::new(cos, 0.0, 0.0, sin))
}
