//! Between poses as they travel and poses to calculate with.

use cell_model::Shape;
use ipc_types::Pose;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rmp::Obstacle;

/// A pose to calculate with. The orientation was validated to be of norm 1.
pub(crate) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.position;
    let [w, i, j, k] = pose.orientation_wxyz;
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k)),
    )
}

/// A pose to send.
pub(crate) fn pose(isometry: &Isometry3<f64>) -> Pose {
    let r = isometry.rotation;
    Pose {
        position: isometry.translation.vector.into(),
        orientation_wxyz: [r.w, r.i, r.j, r.k],
    }
}

/// The rounded box around a shape at `pose`. A cylinder counts as the box around
/// it, a bin as if it were full.
pub(crate) fn around(shape: &Shape, pose: Isometry3<f64>) -> Obstacle {
    let (half_extents, radius) = match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => (Vector3::from(size_m) * 0.5, 0.0),
        Shape::Sphere { radius_m } => (Vector3::zeros(), radius_m),
        Shape::Cylinder { radius_m, height_m } => {
            (Vector3::new(radius_m, radius_m, 0.5 * height_m), 0.0)
        }
        Shape::Capsule { radius_m, height_m } => (Vector3::new(0.0, 0.0, 0.5 * height_m), radius_m),
    };
    Obstacle {
        pose,
        half_extents,
        radius,
    }
}
