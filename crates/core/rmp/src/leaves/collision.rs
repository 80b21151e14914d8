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

use nalgebra::Vector3;

use super::Floor;
use crate::CollisionParameters;
use crate::lanes::wide3::{self, Wide3, dot};
use crate::lanes::{Lanes, exp};
use crate::obstacles::packed::Block;

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

    /// Distance beyond which a leaf weighs exactly nothing (m).
    pub(crate) fn reach(&self) -> f64 {
        self.radius
    }

    pub(crate) fn set_floor(&mut self, floor: Floor) {
        self.floor = floor.distance();
    }
}

/// Weight along the normal and acceleration, at distance `x` and rate `xd`.
#[inline(always)]
fn response<L: Lanes>(c: &Constants, x: L, xd: L) -> (L, L) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    // In penetration the weight has a pole and turns negative; the floor keeps it positive.
    let x = x.max(L::splat(c.floor));
    let gate = one + exp(xd * L::splat(c.inverse_gate));
    let repulsion = exp(zero - x * L::splat(c.inverse_repulsion));
    let near = (one - x * L::splat(c.inverse_radius)).max(zero);
    let weight_divisor = x * L::splat(c.inverse_exploder) + L::splat(c.exploder_eps);
    let drag_divisor = x * L::splat(c.inverse_damping) + L::splat(c.damping_eps);
    // One division serves weight and drag: it is the slowest operation of the kernel.
    let common = one / (gate * weight_divisor * drag_divisor);
    let weight = near * near * L::splat(c.metric_scalar) * common * drag_divisor;
    let drag = xd * L::splat(c.damping_gain) * common * weight_divisor;
    (weight, repulsion * L::splat(c.repulsion_gain) - drag)
}

/// Motion of four spheres.
#[derive(Clone, Copy)]
pub(crate) struct Spheres<L> {
    pub(crate) position: Wide3<L>,
    pub(crate) velocity: Wide3<L>,
    pub(crate) bias: Wide3<L>,
    pub(crate) radius: L,
}

/// Sum of the leaves of each of four spheres: the upper triangle of the weight, row by
/// row, the force, and the least distance to any obstacle (m).
#[derive(Clone, Copy)]
pub(crate) struct Sum<L> {
    pub(crate) metric: [L; 6],
    pub(crate) force: Wide3<L>,
    pub(crate) nearest: L,
}

impl<L: Lanes> Sum<L> {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        let zero = L::splat(0.0);
        Self {
            metric: [zero; 6],
            force: [zero; 3],
            nearest: L::splat(f64::INFINITY),
        }
    }

    /// Adds the leaves against an obstacle at these distances (m), along these normals.
    #[inline(always)]
    pub(crate) fn add(&mut self, c: &Constants, spheres: &Spheres<L>, distance: L, n: &Wide3<L>) {
        let x = distance - spheres.radius;
        self.nearest = x.min(self.nearest);
        // Exactly zero beyond the reach, so leaving the leaf out changes no bit.
        if x.gt(L::splat(c.radius)).all() {
            return;
        }
        let (weight, a) = response(c, x, dot(n, &spheres.velocity));
        let force = weight * (a - dot(n, &spheres.bias));
        let w = wide3::scale(weight, n);
        let [xx, xy, xz, yy, yz, zz] = &mut self.metric;
        *xx = *xx + w[0] * n[0];
        *xy = *xy + w[0] * n[1];
        *xz = *xz + w[0] * n[2];
        *yy = *yy + w[1] * n[1];
        *yz = *yz + w[1] * n[2];
        *zz = *zz + w[2] * n[2];
        self.force = wide3::add(&self.force, &wide3::scale(force, n));
    }
}

/// A bit for each of four obstacles that is not farther than `reach` (m) from a point.
#[inline(always)]
pub(crate) fn within<L: Lanes>(block: &Block, point: &Vector3<f64>, reach: f64) -> u32 {
    let row = |row: usize| L::load(&block.0[row]);
    let zero = L::splat(0.0);
    let offset = wide3::sub(&wide3::splat(point), &[row(0), row(1), row(2)]);
    let out = [
        (dot(&[row(3), row(4), row(5)], &offset).abs() - row(12)).max(zero),
        (dot(&[row(6), row(7), row(8)], &offset).abs() - row(13)).max(zero),
        (dot(&[row(9), row(10), row(11)], &offset).abs() - row(14)).max(zero),
    ];
    let limit = row(15) + L::splat(reach);
    dot(&out, &out).le(limit * limit).bits()
}
