//! Vectors of three, a lane a sphere or an obstacle. Written out without closures: an
//! intrinsic inside a closure is not inlined.

use nalgebra::Vector3;

use super::Lanes;

/// x, y and z.
pub(crate) type Wide3<L> = [L; 3];

#[inline(always)]
pub(crate) fn splat<L: Lanes>(v: &Vector3<f64>) -> Wide3<L> {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

#[inline(always)]
pub(crate) fn dot<L: Lanes>(a: &Wide3<L>, b: &Wide3<L>) -> L {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn add<L: Lanes>(a: &Wide3<L>, b: &Wide3<L>) -> Wide3<L> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<L: Lanes>(a: &Wide3<L>, b: &Wide3<L>) -> Wide3<L> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scale<L: Lanes>(by: L, v: &Wide3<L>) -> Wide3<L> {
    [by * v[0], by * v[1], by * v[2]]
}

#[inline(always)]
pub(crate) fn cross<L: Lanes>(a: &Wide3<L>, b: &Wide3<L>) -> Wide3<L> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
