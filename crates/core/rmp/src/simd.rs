//! AVX2 lanes and the choice of lanes at run time: the crate's only `unsafe`.
//!
//! A binary for any x86-64 contains the AVX2 kernel and detects the processor once. No fused
//! multiply-add is used, so that every choice gives the same bits (ADR 0020).
#![allow(
    clippy::inline_always,
    reason = "lanes are compiled for the instruction set of the function they are inlined into"
)]
#![allow(
    unsafe_code,
    reason = "intrinsics, and calls of functions compiled for AVX2, are unsafe; each is guarded by Path::best"
)]

#[cfg(test)]
use crate::lanes::Scalar;
use crate::sweep::{Nearest, Sweep};

/// Which implementation of the lanes runs the collision kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Path {
    /// Plain arrays: the reference of the tests.
    #[cfg(test)]
    Scalar,
    /// The `wide` crate for the target of the build.
    Portable,
    /// 256-bit registers; only ever made by [`Path::best`].
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Path {
    /// The fastest the processor has.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        // Detected, not assumed by a build flag: one binary runs on every machine of a fleet.
        if std::arch::is_x86_feature_detected!("avx2") {
            return Self::Avx2;
        }
        Self::Portable
    }

    /// Adds the collision leaves of all spheres against all obstacles.
    pub(crate) fn run(self, sweep: &mut Sweep<'_>) -> Nearest {
        match self {
            #[cfg(test)]
            Self::Scalar => sweep.run::<Scalar>(),
            Self::Portable => sweep.run::<wide::f64x4>(),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this variant is only made where AVX2 was detected.
            Self::Avx2 => unsafe { x86::run(sweep) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{
        __m256d, __m256i, _CMP_EQ_OQ, _CMP_GT_OQ, _CMP_LE_OQ, _mm256_add_epi64, _mm256_add_pd,
        _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_castpd_si256,
        _mm256_castsi256_pd, _mm256_cmp_pd, _mm256_div_pd, _mm256_loadu_pd, _mm256_max_pd,
        _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_set1_epi64x,
        _mm256_set1_pd, _mm256_slli_epi64, _mm256_sqrt_pd, _mm256_storeu_pd, _mm256_sub_pd,
    };
    use std::ops::{Add, Div, Mul, Sub};

    use crate::lanes::{LANES, Lanes};
    use crate::sweep::{Nearest, Sweep};

    /// # Safety
    /// The processor must have AVX2.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn run(sweep: &mut Sweep<'_>) -> Nearest {
        sweep.run::<Avx>()
    }

    /// One 256-bit register. Its methods are inlined into [`run`] alone, where
    /// AVX2 is enabled; that is the safety argument of every block below.
    #[derive(Clone, Copy)]
    struct Avx(__m256d);

    macro_rules! operator {
        ($trait:ident, $method:ident, $intrinsic:ident) => {
            impl $trait for Avx {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: only reached through `run`, see `Avx`.
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        };
    }
    operator!(Add, add, _mm256_add_pd);
    operator!(Sub, sub, _mm256_sub_pd);
    operator!(Mul, mul, _mm256_mul_pd);
    operator!(Div, div, _mm256_div_pd);

    impl Lanes for Avx {
        #[inline(always)]
        fn load(values: &[f64; LANES]) -> Self {
            // SAFETY: only reached through `run`; reads the four values given.
            Self(unsafe { _mm256_loadu_pd(values.as_ptr()) })
        }
        #[inline(always)]
        fn splat(value: f64) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_set1_pd(value) })
        }
        #[inline(always)]
        fn to_array(self) -> [f64; LANES] {
            let mut out = [0.0; LANES];
            // SAFETY: only reached through `run`; writes the four values of `out`.
            unsafe { _mm256_storeu_pd(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn gt(self, other: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn same(self, other: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_cmp_pd::<_CMP_EQ_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn select(self, yes: Self, no: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_blendv_pd(no.0, yes.0, self.0) })
        }
        #[inline(always)]
        fn all(self) -> bool {
            // SAFETY: only reached through `run`, see `Avx`.
            unsafe { _mm256_movemask_pd(self.0) == 0b1111 }
        }
        #[inline(always)]
        fn any(self) -> bool {
            // SAFETY: only reached through `run`, see `Avx`.
            unsafe { _mm256_movemask_pd(self.0) != 0 }
        }
        #[inline(always)]
        fn bits(self) -> u32 {
            // SAFETY: only reached through `run`, see `Avx`.
            unsafe { _mm256_movemask_pd(self.0) }.cast_unsigned()
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_sqrt_pd(self.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
        }
        #[inline(always)]
        fn with_sign_of(self, sign: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe {
                let bit = _mm256_set1_pd(-0.0);
                _mm256_or_pd(_mm256_andnot_pd(bit, self.0), _mm256_and_pd(bit, sign.0))
            })
        }
        #[inline(always)]
        fn power_of_two(self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe {
                let bits: __m256i = _mm256_castpd_si256(self.0);
                let biased = _mm256_add_epi64(bits, _mm256_set1_epi64x(1023));
                _mm256_castsi256_pd(_mm256_slli_epi64::<52>(biased))
            })
        }
        // The instruction returns its second operand for equal ones, as the default does.
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_max_pd(self.0, other.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: only reached through `run`, see `Avx`.
            Self(unsafe { _mm256_min_pd(self.0, other.0) })
        }
    }
}
