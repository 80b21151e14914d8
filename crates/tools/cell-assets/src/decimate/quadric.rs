//! The squared distance to a set of planes, as one quadratic form.
//!
//! Garland and Heckbert, "Surface simplification using quadric error metrics",
//! SIGGRAPH 1997.

use crate::mesh::{Vec3, cross, dot, scale};

/// Below this share of the cubed trace the form is flat in some direction, and
/// its minimum anywhere along it.
const FLAT: f64 = 1e-5;

/// p' A p + 2 b' p + c, with A symmetric.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Quadric {
    /// xx, xy, xz, yy, yz, zz.
    a: [f64; 6],
    b: Vec3,
    c: f64,
}

impl Quadric {
    /// `weight` times the squared distance to the plane through `point` with
    /// unit `normal`.
    pub(super) fn plane(normal: Vec3, point: Vec3, weight: f64) -> Self {
        let [x, y, z] = normal;
        let d = -dot(normal, point);
        Self {
            a: [x * x, x * y, x * z, y * y, y * z, z * z].map(|v| v * weight),
            b: scale(normal, d * weight),
            c: d * d * weight,
        }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            a: std::array::from_fn(|i| self.a[i] + other.a[i]),
            b: std::array::from_fn(|i| self.b[i] + other.b[i]),
            c: self.c + other.c,
        }
    }

    fn rows(&self) -> [Vec3; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }

    /// Never below zero, though rounding would have it so.
    pub(super) fn at(&self, p: Vec3) -> f64 {
        let ap = self.rows().map(|row| dot(row, p));
        (dot(p, ap) + 2.0 * dot(self.b, p) + self.c).max(0.0)
    }

    /// Where it is least; none where that is not one well-defined point.
    pub(super) fn minimum(&self) -> Option<Vec3> {
        let [x, y, z] = self.rows();
        let (yz, zx, xy) = (cross(y, z), cross(z, x), cross(x, y));
        let determinant = dot(x, yz);
        let trace = self.a[0] + self.a[3] + self.a[5];
        // Negated, so that NaN counts as flat.
        if !(determinant.abs() > FLAT * trace * trace * trace) {
            return None;
        }
        // The inverse's columns are these cross products over the determinant.
        let point = [0, 1, 2]
            .map(|i| -(yz[i] * self.b[0] + zx[i] * self.b[1] + xy[i] * self.b[2]) / determinant);
        point.iter().all(|c| c.is_finite()).then_some(point)
    }
}
