//! The directions in which fingers close around a shape, and from which they come.

use std::f64::consts::FRAC_1_SQRT_2;

use cell_model::Shape;
use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::candidate::Approach;

/// A direction this near to the vertical is vertical (cosine of 10 degrees).
const VERTICAL: f64 = 0.985;

/// A direction in which fingers close around a shape, and half of the length on which it has
/// its width, as a function of the approach.
pub(crate) struct Closing {
    pub(crate) axis: Vector3<f64>,
    /// Half lengths of the face, along two unit vectors (m).
    face: [(Vector3<f64>, f64); 2],
}

impl Closing {
    /// Half of the length of the face along `approach` (m).
    pub(crate) fn half(&self, approach: &Vector3<f64>) -> f64 {
        let along = |(axis, half): &(Vector3<f64>, f64)| {
            let part = approach.dot(axis).abs();
            if part < 1.0e-6 {
                f64::INFINITY
            } else {
                half / part
            }
        };
        self.face.iter().map(along).fold(f64::INFINITY, f64::min)
    }
}

/// The directions in which a shape has two sides to press on.
pub(crate) fn closings(shape: &Shape, pose: &Isometry3<f64>) -> Vec<Closing> {
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| pose.rotation * axis);
    match *shape {
        Shape::Box { size_m } | Shape::Bin { size_m, .. } => {
            let [a, b, c] = size_m.map(|size| 0.5 * size);
            let closing = |axis, face| Closing { axis, face };
            vec![
                closing(x, [(y, b), (z, c)]),
                closing(y, [(z, c), (x, a)]),
                closing(z, [(x, a), (y, b)]),
            ]
        }
        // Any direction: those of the world, so that a ball that rolled is gripped the same way.
        Shape::Sphere { .. } => around(&Vector3::z())
            .map(|axis| Closing {
                axis,
                face: [(axis.cross(&Vector3::z()), 0.0), (Vector3::z(), 0.0)],
            })
            .collect(),
        Shape::Cylinder { radius_m, height_m } => {
            let mut all = round(&z, 0.5 * height_m);
            all.push(Closing {
                axis: z,
                face: [(x, radius_m), (y, radius_m)],
            });
            all
        }
        Shape::Capsule { height_m, .. } => round(&z, 0.5 * height_m),
    }
}

/// Across a round body along `axis`, on lines with half this length (m).
fn round(axis: &Vector3<f64>, half_m: f64) -> Vec<Closing> {
    around(axis)
        .map(|across| Closing {
            axis: across,
            face: [(*axis, half_m), (axis.cross(&across), 0.0)],
        })
        .collect()
}

/// Four directions across `axis`, 45 degrees apart; one of them is level.
fn around(axis: &Vector3<f64>) -> impl Iterator<Item = Vector3<f64>> {
    let level = Vector3::z().cross(axis);
    let first = if level.norm() > 0.1 {
        level.normalize()
    } else {
        Vector3::x()
    };
    let second = axis.cross(&first);
    let h = FRAC_1_SQRT_2;
    [first, h * (first + second), second, h * (second - first)].into_iter()
}

/// Approaches across a direction in which fingers close; none from below.
pub(crate) fn approaches(closing: &Vector3<f64>) -> Vec<(Approach, Vector3<f64>)> {
    let down = -Vector3::z();
    let mut all = Vec::new();
    if closing.z.abs() > VERTICAL {
        // One finger above and one below.
        let h = FRAC_1_SQRT_2;
        for (x, y) in [(1.0, 0.0), (h, h), (0.0, 1.0), (-h, h)] {
            let level = Vector3::new(x, y, 0.0);
            let across = (level - closing * closing.dot(&level)).normalize();
            all.extend([(Approach::Side, across), (Approach::Side, -across)]);
        }
        return all;
    }
    let steep = (down - closing * closing.dot(&down)).normalize();
    let side = closing.cross(&steep);
    let h = FRAC_1_SQRT_2;
    for direction in [steep, h * (steep + side), h * (steep - side), side, -side] {
        let approach = match -direction.z {
            cosine if cosine > VERTICAL => Approach::Above,
            cosine if cosine > 0.3 => Approach::Oblique,
            cosine if cosine > -0.1 => Approach::Side,
            _ => continue,
        };
        all.push((approach, direction));
    }
    all
}

/// Orientation of a TCP that points along `direction` and whose fingers close along `axis`.
pub(crate) fn rotation(direction: &Vector3<f64>, axis: &Vector3<f64>) -> UnitQuaternion<f64> {
    let axes = Matrix3::from_columns(&[axis.cross(direction), *axis, *direction]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes))
}
