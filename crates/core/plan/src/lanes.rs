//! As many single-precision numbers as the processor computes at once, chosen at run time by
//! `pulp`. Each operation is one IEEE operation per lane, and nothing is fused, so that each
//! choice gives the same bits. A plan is computed again by a replay, perhaps on another
//! processor, and has to be the same (ADR 0019).
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

use std::ops::{Add, Mul, Sub};

use pulp::{Simd, bytemuck};

/// Configurations in one pass: the number of lanes of the widest registers.
// A processor with narrower registers takes several for one pass, with the same bits (ADR
// 0019).
pub const LANES: usize = 16;

/// One number for each configuration.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Row(pub(crate) [f32; LANES]);

/// One register.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    simd: S,
    value: S::f32s,
}

/// A vector of three.
pub(crate) type Wide3<S> = [Wide<S>; 3];

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        let value = simd.splat_f32s(value);
        Self { simd, value }
    }

    #[inline(always)]
    pub(crate) fn splat3(simd: S, values: &[f32; 3]) -> Wide3<S> {
        [
            Self::splat(simd, values[0]),
            Self::splat(simd, values[1]),
            Self::splat(simd, values[2]),
        ]
    }

    /// The numbers of `row` that are in register `register` of it.
    #[inline(always)]
    pub(crate) fn load(simd: S, row: &Row, register: usize) -> Self {
        let value = S::as_simd_f32s(&row.0).0[register];
        Self { simd, value }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        let value = self.simd.abs_f32s(self.value);
        Self { value, ..self }
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        let value = self.simd.sqrt_f32s(self.value);
        Self { value, ..self }
    }

    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        let value = self.simd.max_f32s(self.value, other.value);
        Self { value, ..self }
    }

    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        let value = self.simd.min_f32s(self.value, other.value);
        Self { value, ..self }
    }

    /// Lane by lane `yes` if it is less than `than`, else `no`.
    #[inline(always)]
    pub(crate) fn choose_less(self, than: Self, yes: Self, no: Self) -> Self {
        let mask = self.simd.less_than_f32s(self.value, than.value);
        let value = self.simd.select_f32s(mask, yes.value, no.value);
        Self { value, ..self }
    }

    /// Whether any number is less than that of `other`.
    #[inline(always)]
    pub(crate) fn any_less(self, other: Self) -> bool {
        // Any lane, not a count: lanes are never added, so their number changes no result.
        let mask = self.simd.less_than_f32s(self.value, other.value);
        let bytes = bytemuck::bytes_of(&mask).iter();
        bytes.fold(0, |all, byte| all | byte) != 0
    }

    /// Sine and cosine (rad), to 1e-6 within some turns.
    #[inline(always)]
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        /// `1.5 * 2^23`: adding it rounds to an integer.
        const ROUNDER: f32 = 12_582_912.0;
        /// `2 pi` in two parts, the first with so few digits that a multiple is exact.
        const TURN_HIGH: f32 = 6.28125;
        const TURN_LOW: f32 = 0.001_935_307_2;
        let c = |value: f32| Self::splat(self.simd, value);
        let turns = self * c(0.5 * std::f32::consts::FRAC_1_PI) + c(ROUNDER) - c(ROUNDER);
        // Half the angle is within a quarter turn, where both series converge fast.
        let half = (self - turns * c(TURN_HIGH) - turns * c(TURN_LOW)) * c(0.5);
        let x = half * half;
        let sine = c(1.0 / 362_880.0) - x * c(1.0 / 39_916_800.0);
        let sine = c(1.0 / 120.0) - x * (c(1.0 / 5_040.0) - x * sine);
        let sine = half * (c(1.0) - x * (c(1.0 / 6.0) - x * sine));
        let cosine = c(1.0 / 40_320.0) - x * (c(1.0 / 3_628_800.0) - x * c(1.0 / 479_001_600.0));
        let cosine = c(1.0 / 24.0) - x * (c(1.0 / 720.0) - x * cosine);
        let cosine = c(1.0) - x * (c(0.5) - x * cosine);
        let twice = sine + sine;
        (twice * cosine, c(1.0) - twice * sine)
    }
}

impl<S: Simd> Add for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let value = self.simd.add_f32s(self.value, other.value);
        Self { value, ..self }
    }
}

impl<S: Simd> Sub for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let value = self.simd.sub_f32s(self.value, other.value);
        Self { value, ..self }
    }
}

impl<S: Simd> Mul for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let value = self.simd.mul_f32s(self.value, other.value);
        Self { value, ..self }
    }
}

#[inline(always)]
pub(crate) fn dot<S: Simd>(a: &Wide3<S>, b: &Wide3<S>) -> Wide<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn add<S: Simd>(a: &Wide3<S>, b: &Wide3<S>) -> Wide3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<S: Simd>(a: &Wide3<S>, b: &Wide3<S>) -> Wide3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scale<S: Simd>(by: Wide<S>, v: &Wide3<S>) -> Wide3<S> {
    [by * v[0], by * v[1], by * v[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_agree_with_libm() {
        for step in -4000_i16..4000 {
            let x = f32::from(step) * 0.003;
            let (sine, cosine) = Wide::splat(pulp::Scalar, x).sin_cos();
            let (expected, other) = f64::from(x).sin_cos();
            assert!((f64::from(sine.value) - expected).abs() < 1e-6, "{x}");
            assert!((f64::from(cosine.value) - other).abs() < 1e-6, "{x}");
        }
    }
}
