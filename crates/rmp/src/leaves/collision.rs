//! Push of a sphere away from an obstacle. With `x` the signed distance of the
//! surfaces, `n` the normal and `xd = n . v`:
//! `s = 1 - sigmoid(xd / vd)`, `g = (1 - x / r)^2` for `x <= r` else 0,
//! `a = kp exp(-x / lp) - kd s xd / (x / ld + ed)`, `M = s g mu / (x / lm + em)`.
//! The curvature is `n . (Jdot qd)`; that of the normal itself is left out, as in
//! the published results.
//!
//! In penetration the published weight has a pole and turns negative beyond it:
//! with [`Floor::Contact`] `x` counts as zero there. The normal still points the
//! way out.
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

use nalgebra::{Matrix3, Vector3};

use super::Floor;
use crate::lanes::{LANES, Lanes, exp};
use crate::obstacles::Block;
use crate::{CollisionParameters, PointMotion};

/// The tuning with its lengths inverted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Constants {
    inverse_gate: f64,
    inverse_repulsion: f64,
    inverse_damping: f64,
    inverse_exploder: f64,
    inverse_radius: f64,
    radius: f64,
    repulsion_gain: f64,
    damping_gain: f64,
    damping_eps: f64,
    metric_scalar: f64,
    exploder_eps: f64,
    /// Least distance that counts (m).
    floor: f64,
}

impl Constants {
    pub(crate) fn new(p: &CollisionParameters) -> Self {
        Self {
            inverse_gate: 1.0 / p.damping_velocity_gate_length_scale,
            inverse_repulsion: 1.0 / p.repulsion_std_dev,
            inverse_damping: 1.0 / p.damping_std_dev,
            inverse_exploder: 1.0 / p.metric_exploder_std_dev,
            inverse_radius: 1.0 / p.metric_modulation_radius,
            radius: p.metric_modulation_radius,
            repulsion_gain: p.repulsion_gain,
            damping_gain: p.damping_gain,
            damping_eps: p.damping_robustness_eps,
            metric_scalar: p.metric_scalar,
            exploder_eps: p.metric_exploder_eps,
            floor: Floor::Contact.distance(),
        }
    }

    pub(crate) fn set_floor(&mut self, floor: Floor) {
        self.floor = floor.distance();
    }
}

/// A sphere in motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Query {
    pub(crate) point: PointMotion,
    pub(crate) radius: f64,
}

/// Sum of the leaves of one sphere, and its least distance to any obstacle, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sum {
    pub(crate) metric: Matrix3<f64>,
    pub(crate) force: Vector3<f64>,
    pub(crate) clearance: f64,
}

/// Three lanes wide vector.
type Wide3<L> = [L; 3];

#[inline(always)]
fn splat3<L: Lanes>(v: &Vector3<f64>) -> Wide3<L> {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

#[inline(always)]
fn dot<L: Lanes>(a: &Wide3<L>, b: &Wide3<L>) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Distance to the core box grown by its radius, and the outward normal.
#[inline(always)]
fn surface<L: Lanes>(rows: &[L; 16], position: &Wide3<L>) -> (L, Wide3<L>) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let offset: Wide3<L> = std::array::from_fn(|i| position[i] - rows[i]);
    let axis = |i: usize| [rows[3 + 3 * i], rows[4 + 3 * i], rows[5 + 3 * i]];
    let local: Wide3<L> = std::array::from_fn(|i| dot(&axis(i), &offset));
    let beyond: Wide3<L> = std::array::from_fn(|i| local[i].abs() - rows[12 + i]);
    let out: Wide3<L> = std::array::from_fn(|i| beyond[i].max(zero));
    let squared = dot(&out, &out);
    let inside = squared.le(zero);
    let outer = squared.sqrt();
    let deepest = beyond[0].max(beyond[1]).max(beyond[2]);
    let inverse = one / inside.select(one, outer);
    let mut normal: Wide3<L> = std::array::from_fn(|i| out[i] * inverse);
    if inside.any() {
        // The face least deep inside; the first of equals.
        let x = beyond[0].same(deepest).select(one, zero);
        let y = beyond[1].same(deepest).select(one, zero) * (one - x);
        let z = one - x - y;
        normal = [
            inside.select(x, normal[0]),
            inside.select(y, normal[1]),
            inside.select(z, normal[2]),
        ];
    }
    let signed: Wide3<L> = std::array::from_fn(|i| normal[i].with_sign_of(local[i]));
    let turned: Wide3<L> = std::array::from_fn(|i| {
        rows[3 + i] * signed[0] + rows[6 + i] * signed[1] + rows[9 + i] * signed[2]
    });
    (inside.select(deepest, outer) - rows[15], turned)
}

/// Weight along the normal and acceleration, at distance `x` and rate `xd`.
#[inline(always)]
fn response<L: Lanes>(c: &Constants, x: L, xd: L) -> (L, L) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let x = x.max(L::splat(c.floor));
    let gate = one + exp(xd * L::splat(c.inverse_gate));
    let repulsion = exp(zero - x * L::splat(c.inverse_repulsion));
    let near = (one - x * L::splat(c.inverse_radius)).max(zero);
    let weight_divisor = x * L::splat(c.inverse_exploder) + L::splat(c.exploder_eps);
    let drag_divisor = x * L::splat(c.inverse_damping) + L::splat(c.damping_eps);
    // One division serves weight and drag.
    let common = one / (gate * weight_divisor * drag_divisor);
    let weight = near * near * L::splat(c.metric_scalar) * common * drag_divisor;
    let drag = xd * L::splat(c.damping_gain) * common * weight_divisor;
    (weight, repulsion * L::splat(c.repulsion_gain) - drag)
}

/// Sums all blocks for one sphere. Inlined into each caller, so that it is
/// compiled for the instruction set of that caller.
#[inline(always)]
pub(crate) fn accumulate<L: Lanes>(c: &Constants, query: &Query, blocks: &[Block]) -> Sum {
    let position = splat3::<L>(&query.point.position);
    let velocity = splat3::<L>(&query.point.velocity);
    let bias = splat3::<L>(&query.point.bias);
    let own = L::splat(query.radius);
    let reach = L::splat(c.radius);
    let mut sums = [L::splat(0.0); 9];
    let mut nearest = L::splat(f64::INFINITY);
    for block in blocks {
        let rows: [L; 16] = std::array::from_fn(|i| L::load(&block.0[i]));
        let (distance, n) = surface(&rows, &position);
        let x = distance - own;
        nearest = x.min(nearest);
        if x.gt(reach).all() {
            continue;
        }
        let (weight, a) = response(c, x, dot(&n, &velocity));
        let force = weight * (a - dot(&n, &bias));
        let (wx, wy, wz) = (weight * n[0], weight * n[1], weight * n[2]);
        let terms = [
            wx * n[0],
            wx * n[1],
            wx * n[2],
            wy * n[1],
            wy * n[2],
            wz * n[2],
            force * n[0],
            force * n[1],
            force * n[2],
        ];
        sums = std::array::from_fn(|i| sums[i] + terms[i]);
    }
    finish(&sums, nearest)
}

#[inline(always)]
fn finish<L: Lanes>(sums: &[L; 9], nearest: L) -> Sum {
    let t: [f64; 9] = std::array::from_fn(|i| {
        let [a, b, c, d]: [f64; LANES] = sums[i].to_array();
        (a + b) + (c + d)
    });
    let clearance = nearest
        .to_array()
        .iter()
        .fold(f64::INFINITY, |least, &x| if x < least { x } else { least });
    Sum {
        metric: Matrix3::new(t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5]),
        force: Vector3::new(t[6], t[7], t[8]),
        clearance,
    }
}
