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

/// A shape at `pose`; a bin counts as if it were full.
pub(crate) fn around(shape: &Shape, pose: Isometry3<f64>) -> Obstacle {
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            Obstacle::cuboid(pose, Vector3::from(size_m))
        }
        Shape::Sphere { radius_m } => Obstacle::rounded_box(pose, Vector3::zeros(), radius_m),
        Shape::Cylinder { radius_m, height_m } => Obstacle::cylinder(pose, radius_m, height_m),
        Shape::Capsule { radius_m, height_m } => {
            Obstacle::rounded_box(pose, Vector3::new(0.0, 0.0, 0.5 * height_m), radius_m)
        }
    }
}
