//! Repulsion of two spheres of one robot, as that of a sphere from an obstacle (`collision`),
//! with weights of ours: a wide reach, because the same limited joints move both parts, and a
//! weight that falls fast, because parts that pass each other at some distance are not in
//! danger.
//!
//! With `x` the distance of the surfaces, `n` the unit vector from the second centre to
//! the first, `xd` its rate: `J = n . (J1 - J2)`. Joints that move both do not count.
//! The curvature is `n . (Jdot1 qd - Jdot2 qd)`, without that of the normal.

use nalgebra::Vector3;

use super::approach_gate;
use crate::PointMotion;

/// Distance of the surfaces beyond which the weight is zero (m).
// As far as arms with a low acceleration limit need to brake.
pub(crate) const REACH_M: f64 = 0.25;
/// Distance that is kept: a smaller one counts as contact (m).
const MARGIN_M: f64 = 0.005;
/// Repulsion gain (m/s²) and the distance over which it falls (m).
const REPULSION: f64 = 800.0;
const REPULSION_M: f64 = 0.01;
/// Damping gain (1/s), the distance over which it falls (m), and the term that keeps it
/// finite.
const DAMPING: f64 = 50.0;
const DAMPING_M: f64 = 0.04;
const DAMPING_EPS: f64 = 0.01;
/// Parts nearer than this push each other away, at rest, too (m).
const PUSH_M: f64 = 0.01;
/// Farther away they may approach at this rate of the distance (1/s): the leaf only brakes a
/// faster approach, so that an arm can hold its parts some centimetres apart.
// With a repulsion at any distance a UR10 that flips a bin, with 34 mm between upper arm and
// wrist, was held off its goal.
const APPROACH: f64 = 3.0;
/// Speed over which the leaf fades in (m/s).
const GATE_M_S: f64 = 0.01;
/// If the approach is slower than allowed by so many times this speed, the leaf has a weight
/// of 2e-9 of the whole and is left out: so are most leaves of parts that pass each other.
// exp(-20) is 2e-9.
const GATES: f64 = 20.0;
/// Weight, the distance over which it falls (m), and the term that keeps it finite.
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

/// The leaf of two spheres whose centres are `distance` apart and whose surfaces are `x`
/// apart; `None` if the centres coincide, or if they approach more slowly than allowed.
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
