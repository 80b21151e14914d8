//! Conversion between the vectors of the engine, of nalgebra and of the messages.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d_f64::math::{Matrix, Pose, Rotation, Vector};

/// nalgebra to engine.
pub(crate) fn to_vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Engine to nalgebra.
pub(crate) fn from_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

/// nalgebra to engine.
pub(crate) fn to_pose(pose: &Isometry3<f64>) -> Pose {
    let q = pose.rotation;
    Pose::from_parts(
        to_vector(&pose.translation.vector),
        Rotation::from_xyzw(q.i, q.j, q.k, q.w),
    )
}

/// Engine to nalgebra.
pub(crate) fn from_pose(pose: &Pose) -> Isometry3<f64> {
    let q = pose.rotation;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(q.w, q.x, q.y, q.z));
    Isometry3::from_parts(Translation3::from(from_vector(pose.translation)), rotation)
}

/// Engine to nalgebra; `None` where a number is not finite.
pub(crate) fn finite_pose(pose: &Pose) -> Option<Isometry3<f64>> {
    let (p, q) = (pose.translation, pose.rotation);
    let numbers = [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
    (numbers.iter().all(|x| x.is_finite())).then(|| from_pose(pose))
}

/// nalgebra to engine, by columns.
pub(crate) fn to_matrix(m: &Matrix3<f64>) -> Matrix {
    Matrix::from_cols_array(&[
        m[(0, 0)],
        m[(1, 0)],
        m[(2, 0)],
        m[(0, 1)],
        m[(1, 1)],
        m[(2, 1)],
        m[(0, 2)],
        m[(1, 2)],
        m[(2, 2)],
    ])
}

/// nalgebra to the wire, normalised there.
pub(crate) fn to_wire(pose: &Isometry3<f64>) -> ipc_types::Pose {
    let q = UnitQuaternion::new_normalize(*pose.rotation.quaternion());
    ipc_types::Pose {
        position: pose.translation.vector.into(),
        orientation_wxyz: [q.w, q.i, q.j, q.k],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_comes_back_from_the_engine_and_reaches_the_wire() {
        let rotation = UnitQuaternion::from_euler_angles(0.3, -0.2, 1.1);
        let pose = Isometry3::from_parts(Translation3::new(1.0, -2.0, 3.0), rotation);
        assert!((from_pose(&to_pose(&pose)).to_matrix() - pose.to_matrix()).norm() < 1e-15);
        let wire = to_wire(&pose);
        assert_eq!(wire.position, [1.0, -2.0, 3.0]);
        assert!((wire.orientation_wxyz[0] - rotation.w).abs() < 1e-15);
        let turned = to_matrix(rotation.to_rotation_matrix().matrix()) * Vector::new(1.0, 2.0, 3.0);
        assert!((from_vector(turned) - rotation * Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-15);
    }
}
