//! Four-lane arithmetic: one trait with three implementations (plain arrays,
//! `wide`, AVX2 in `simd.rs`) that agree bit for bit. Every operation is one IEEE
//! operation per lane; nothing is fused or reordered.
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]

pub(crate) mod wide3;

use std::ops::{Add, Div, Mul, Sub};

use wide::{Select, f64x4};

/// Lanes of one block.
// Fixed at four on every processor: sums over lanes have one order, and results the same bits.
pub(crate) const LANES: usize = 4;

/// Four `f64`. A mask is a value of the same type whose lanes are all ones or
/// all zeros bitwise.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    fn load(values: &[f64; LANES]) -> Self;
    fn to_array(self) -> [f64; LANES];
    /// Mask of `self > other`.
    fn gt(self, other: Self) -> Self;
    /// Mask of `self <= other`.
    fn le(self, other: Self) -> Self;
    /// Mask of `self == other`.
    fn same(self, other: Self) -> Self;
    /// `self` as mask: `yes` where set, else `no`.
    fn select(self, yes: Self, no: Self) -> Self;
    /// `self` as mask: whether all lanes are set.
    fn all(self) -> bool;
    /// `self` as mask: whether any lane is set.
    fn any(self) -> bool;
    /// `self` as mask: a bit for each lane.
    fn bits(self) -> u32;
    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// Magnitude of `self`, sign of `sign`.
    fn with_sign_of(self, sign: Self) -> Self;
    /// `2^k` from the bits of `k + 1.5 * 2^52`, k in -1022..=1023.
    fn power_of_two(self) -> Self;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::load(&[value; LANES])
    }

    /// Sum of the lanes.
    #[inline(always)]
    // In pairs, in all implementations: another order would give other last bits.
    fn total(self) -> f64 {
        let [a, b, c, d]: [f64; LANES] = self.to_array();
        (a + b) + (c + d)
    }

    /// The greater; `other` where equal.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    /// The lesser; `other` where equal.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        other.gt(self).select(self, other)
    }
}

/// `1.5 * 2^52`: adding it rounds to an integer in the low bits of the mantissa.
const ROUNDER: f64 = 6_755_399_441_055_744.0;
/// `ln 2` in two parts (fdlibm's split), so that `k ln 2` is exact in the first.
const LN2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// `e^x` for `x` clamped to +-500: argument reduction by `k ln 2`, then the Taylor
/// polynomial of degree 13 on |r| <= ln 2 / 2, whose truncation error is 4e-18.
#[inline(always)]
pub(crate) fn exp<L: Lanes>(x: L) -> L {
    let s = L::splat;
    // Within this the power of two has a normal exponent; the weights of leaves need less.
    let x = x.max(s(-500.0)).min(s(500.0));
    let rounded = x * s(std::f64::consts::LOG2_E) + s(ROUNDER);
    let k = rounded - s(ROUNDER);
    let r = x - k * s(LN2_HIGH) - k * s(LN2_LOW);
    let r2 = r * r;
    let r4 = r2 * r2;
    let pair = |even: f64, odd: f64| s(1.0 / even) + s(1.0 / odd) * r;
    let low = pair(1.0, 1.0) + pair(2.0, 6.0) * r2;
    let middle = pair(24.0, 120.0) + pair(720.0, 5040.0) * r2;
    let high = pair(40_320.0, 362_880.0) + pair(3_628_800.0, 39_916_800.0) * r2;
    let top = pair(479_001_600.0, 6_227_020_800.0);
    let polynomial = low + (middle + (high + top * r4) * r4) * r4;
    polynomial * rounded.power_of_two()
}

#[inline(always)]
pub(crate) fn power_of_two_bits(rounded: f64) -> f64 {
    f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52)
}

/// Plain arrays: the scalar twin the other two are compared with.
#[cfg(test)]
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scalar([f64; LANES]);

#[cfg(test)]
impl Scalar {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(f64, f64) -> bool) -> Self {
        self.zip(other, |a, b| {
            f64::from_bits(if f(a, b) { u64::MAX } else { 0 })
        })
    }
}

#[cfg(test)]
macro_rules! scalar_operator {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Scalar {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, |a, b| a $operator b)
            }
        }
    };
}
#[cfg(test)]
scalar_operator!(Add, add, +);
#[cfg(test)]
scalar_operator!(Sub, sub, -);
#[cfg(test)]
scalar_operator!(Mul, mul, *);
#[cfg(test)]
scalar_operator!(Div, div, /);

#[cfg(test)]
impl Lanes for Scalar {
    #[inline(always)]
    fn load(values: &[f64; LANES]) -> Self {
        Self(*values)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        self.0
    }
    #[inline(always)]
    fn gt(self, other: Self) -> Self {
        self.mask(other, |a, b| a > b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self {
        self.mask(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn same(self, other: Self) -> Self {
        self.mask(other, |a, b| a == b)
    }
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        let pick = |i: usize| {
            if self.0[i].to_bits() == 0 {
                no.0[i]
            } else {
                yes.0[i]
            }
        };
        Self(std::array::from_fn(pick))
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0.iter().all(|lane| lane.to_bits() != 0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0.iter().any(|lane| lane.to_bits() != 0)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        let lanes = self.0.iter().enumerate();
        lanes.fold(0, |bits, (i, lane)| {
            bits | u32::from(lane.to_bits() != 0) << i
        })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        self.zip(sign, f64::copysign)
    }
    #[inline(always)]
    fn power_of_two(self) -> Self {
        self.map(power_of_two_bits)
    }
}

impl Lanes for f64x4 {
    #[inline(always)]
    fn load(values: &[f64; LANES]) -> Self {
        Self::new(*values)
    }
    #[inline(always)]
    fn to_array(self) -> [f64; LANES] {
        Self::to_array(self)
    }
    #[inline(always)]
    fn gt(self, other: Self) -> Self {
        Self::simd_gt(self, other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self {
        Self::simd_le(self, other)
    }
    #[inline(always)]
    fn same(self, other: Self) -> Self {
        Self::simd_eq(self, other)
    }
    #[inline(always)]
    fn select(self, yes: Self, no: Self) -> Self {
        Select::select(self, yes, no)
    }
    #[inline(always)]
    fn all(self) -> bool {
        Self::all(self)
    }
    #[inline(always)]
    fn any(self) -> bool {
        Self::any(self)
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        Self::to_bitmask(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }
    #[inline(always)]
    fn with_sign_of(self, sign: Self) -> Self {
        let bit = Self::splat(-0.0);
        Self::abs(self) | (sign & bit)
    }
    #[inline(always)]
    fn power_of_two(self) -> Self {
        Self::new(Self::to_array(self).map(power_of_two_bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_libm_to_rounding() {
        let mut x = -30.0;
        while x < 30.0 {
            let ours = exp(Scalar::splat(x)).to_array()[0];
            let theirs = libm::exp(x);
            assert!(((ours - theirs) / theirs).abs() < 1e-15, "exp({x})");
            x += 0.0137;
        }
    }
}
