//! Friction along the slip.
//!
//! The engine computes the impulse that would end the slip `v` of a contact point, `K^-1 v` with
//! the 2x2 inverse effective mass `K` of its tangents, and shortens it to the friction limit. At
//! the corner of a face `K` has an off-diagonal element, so that impulse is not along `v`: a box
//! of 100x100x50 mm on a slope is held by 0.540 instead of 0.6, and turned. A surface velocity of `(K / k - I) v`, with the larger eigenvalue `k` of `K`,
//! makes it `v / k`. It vanishes with the slip, so contacts at rest are solved as before (ADR 40).

use rapier3d_f64::prelude::*;

/// Slip below which a correction is less than rounding (m/s).
const LEAST_SLIP_M_S: f64 = 1.0e-12;

/// A free body at a contact, with the sign of its velocity in the slip.
pub(crate) type Side<'b> = (&'b RigidBody, f64);

/// The two directions of a tangent plane.
pub(crate) struct Tangents([Vector; 2]);

impl Tangents {
    /// Of the plane with this normal.
    pub(crate) fn new(normal: Vector) -> Self {
        let other = if normal.x.abs() < 0.6 {
            Vector::X
        } else {
            Vector::Y
        };
        let first = (other - normal * normal.dot(other)).normalize();
        Self([first, normal.cross(first)])
    }

    fn of(&self, vector: Vector) -> [f64; 2] {
        self.0.map(|tangent| tangent.dot(vector))
    }
}

/// Surface velocity that turns the friction at `point` along the slip (m/s, world frame).
/// `surface` is the velocity of a belt there; `sides` are the free bodies.
pub(crate) fn along_slip(
    sides: &[Option<Side<'_>>; 2],
    tangents: &Tangents,
    point: Vector,
    surface: Vector,
) -> Vector {
    let mut slip = surface;
    for (body, sign) in sides.iter().flatten() {
        slip += body.velocity_at_point(point) * *sign;
    }
    let [x, y] = tangents.of(slip);
    if x.abs().max(y.abs()) < LEAST_SLIP_M_S {
        return Vector::ZERO;
    }
    let [k11, k22, k12] = inverse_mass(sides, tangents, point);
    let half = 0.5 * (k11 - k22);
    let largest = 0.5 * (k11 + k22) + (half * half + k12 * k12).sqrt();
    if largest <= 0.0 {
        return Vector::ZERO;
    }
    let scaled = [(k11 * x + k12 * y) / largest, (k12 * x + k22 * y) / largest];
    tangents.0[0] * (scaled[0] - x) + tangents.0[1] * (scaled[1] - y)
}

/// Inverse effective mass of the tangents at a point (1/kg): both diagonal elements, and the
/// other one. For each body `1/m + (r x t)' I^-1 (r x t)`.
fn inverse_mass(sides: &[Option<Side<'_>>; 2], tangents: &Tangents, point: Vector) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (body, _) in sides.iter().flatten() {
        let mass = body.mass_properties();
        let arm = point - mass.world_com;
        let inverse = &mass.effective_world_inv_inertia;
        let turns = tangents.0.map(|tangent| arm.cross(tangent));
        let turned = turns.map(|turn| *inverse * turn);
        sum[0] += mass.effective_inv_mass.x + turns[0].dot(turned[0]);
        sum[1] += mass.effective_inv_mass.x + turns[1].dot(turned[1]);
        sum[2] += turns[0].dot(turned[1]);
    }
    sum
}
