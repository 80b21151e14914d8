//! Push of two spheres of one robot away from each other, as that of a sphere from an
//! obstacle (`collision`), with weights of ours: a wide reach, because both parts are
//! moved by the same limited joints, and a weight that falls fast, because parts that
//! pass each other at some distance are no concern.
//!
//! With `x` the distance of the surfaces, `n` the unit vector from the second centre to
//! the first, `xd` its rate: `J = n . (J1 - J2)`. Joints that move both do not count.
//! The curvature is `n . (Jdot1 qd - Jdot2 qd)`, without that of the normal.

use nalgebra::Vector3;

use super::approach_gate;
use crate::PointMotion;

/// Distance of the surfaces beyond which the weight is zero (m).
pub(crate) const REACH_M: f64 = 0.25;
/// Distance that is kept: what is nearer counts as touching (m).
const MARGIN_M: f64 = 0.005;
/// Repulsion gain (m/s²) and the distance over which it falls (m).
const REPULSION: f64 = 800.0;
const REPULSION_M: f64 = 0.01;
/// Damping gain (1/s), the distance over which it falls (m), and what keeps it finite.
const DAMPING: f64 = 50.0;
const DAMPING_M: f64 = 0.04;
const DAMPING_EPS: f64 = 0.01;
/// Parts nearer than this push each other away, at rest, too (m).
const PUSH_M: f64 = 0.01;
/// Farther away they may approach at this rate of the distance (1/s): the leaf only brakes
/// what is faster, so that an arm can stay with its parts some centimetres apart.
const APPROACH: f64 = 3.0;
/// Speed over which the leaf fades in (m/s).
const GATE_M_S: f64 = 0.01;
/// At so many times this speed below the allowed rate it weighs 2e-9 of the whole, and is
/// left out: of parts that pass each other most leaves are.
const GATES: f64 = 20.0;
/// Weight, the distance over which it falls (m), and what keeps it finite.
const WEIGHT: f64 = 1.0e4;
const WEIGHT_M: f64 = 0.02;
const WEIGHT_EPS: f64 = 0.001;

/// A leaf: unit normal, weight along it, and force with the curvature taken off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leaf {
    pub(crate) normal: Vector3<f64>,
    pub(crate) weight: f64,
    pub(crate) force: f64,
}

/// The leaf of two spheres whose centres are `distance` apart and whose surfaces are
/// `x` apart; none where the centres coincide, or where
/// they approach slower than is allowed.
pub(crate) fn leaf(one: &PointMotion, other: &PointMotion, distance: f64, x: f64) -> Option<Leaf> {
    if distance <= f64::EPSILON {
        return None;
    }
    let normal = (one.position - other.position) / distance;
    let rate = normal.dot(&(one.velocity - other.velocity));
    let x = (x - MARGIN_M).max(0.0);
    let allowed = APPROACH * (x - PUSH_M).max(0.0);
    if rate + allowed > GATES * GATE_M_S {
        return None;
    }
    let bias = normal.dot(&(one.bias - other.bias));
    let gate = approach_gate(rate + allowed, GATE_M_S);
    let near = (1.0 - x / (REACH_M - MARGIN_M)).max(0.0);
    let weight = gate * near * near * WEIGHT / (x / WEIGHT_M + WEIGHT_EPS);
    let drag = DAMPING * gate * rate / (x / DAMPING_M + DAMPING_EPS);
    let acceleration = REPULSION * libm::exp(-x / REPULSION_M) - drag;
    Some(Leaf {
        normal,
        weight,
        force: weight * (acceleration - bias),
    })
}
