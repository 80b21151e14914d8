//! AVX2 lanes and the choice of lanes at run time: the crate's only `unsafe`.
//!
//! A binary for any x86-64 contains the AVX2 kernel and asks the processor once.
//! No fused multiply-add is used, so that every choice gives the same bits.
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
use crate::leaves::collision::{Constants, Query, Sum, accumulate};
use crate::obstacles::Block;

/// Which implementation of the lanes runs the collision kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Path {
    /// Plain arrays: what the tests compare with.
    #[cfg(test)]
    Scalar,
    /// The `wide` crate for whatever the build targets.
    Portable,
    /// 256-bit registers; only ever made by [`Path::best`].
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Path {
    /// The fastest the processor has.
    pub(crate) fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Self::Avx2;
        }
        Self::Portable
    }

    /// Sums the collision leaves of one sphere against all blocks.
    #[inline]
    pub(crate) fn run(self, constants: &Constants, query: &Query, blocks: &[Block]) -> Sum {
        match self {
            #[cfg(test)]
            Self::Scalar => accumulate::<Scalar>(constants, query, blocks),
            Self::Portable => accumulate::<wide::f64x4>(constants, query, blocks),
            #[cfg(target_arch = "x86_64")]
            // SAFETY: this variant is only made where AVX2 was detected.
            Self::Avx2 => unsafe { x86::run(constants, query, blocks) },
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

    use super::{Block, Constants, Query, Sum, accumulate};
    use crate::lanes::{LANES, Lanes};

    /// # Safety
    /// The processor must have AVX2.
    #[target_feature(enable = "avx2")]
    pub(super) unsafe fn run(constants: &Constants, query: &Query, blocks: &[Block]) -> Sum {
        accumulate::<Avx>(constants, query, blocks)
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
        // The instruction returns its second operand where equal, as the default does.
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

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, UnitQuaternion, Vector3};

    use super::*;
    use crate::{CollisionParameters, Obstacle, ObstacleSet, PointMotion};

    const P: CollisionParameters = CollisionParameters {
        damping_gain: 50.0,
        damping_std_dev: 0.04,
        damping_robustness_eps: 1e-2,
        damping_velocity_gate_length_scale: 0.01,
        repulsion_gain: 800.0,
        repulsion_std_dev: 0.01,
        metric_modulation_radius: 0.5,
        metric_scalar: 1e4,
        metric_exploder_std_dev: 0.02,
        metric_exploder_eps: 1e-3,
    };

    fn bits(sum: &Sum) -> Vec<u64> {
        let numbers = sum.metric.iter().chain(sum.force.iter());
        numbers
            .chain([&sum.clearance])
            .map(|x| x.to_bits())
            .collect()
    }

    fn query(position: Vector3<f64>, velocity: Vector3<f64>) -> Query {
        Query {
            point: PointMotion {
                position,
                velocity,
                bias: Vector3::new(0.3, -0.2, 0.1),
            },
            radius: 0.05,
        }
    }

    #[test]
    fn every_choice_of_lanes_gives_the_same_bits() {
        let mut seed = 3_u64;
        let mut next = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let constants = Constants::new(&P);
        for count in [1, 4, 7, 20] {
            let mut set = ObstacleSet::with_capacity(count);
            for _ in 0..count {
                let at = Vector3::new(next(), next(), next());
                let turn = UnitQuaternion::from_euler_angles(next(), next(), next());
                set.add(Obstacle {
                    pose: Isometry3::from_parts(at.into(), turn),
                    half_extents: Vector3::new(next().max(0.0), next().abs(), next().max(0.0))
                        * 0.3,
                    radius: 0.02,
                })
                .unwrap();
            }
            for _ in 0..2000 {
                // Near, far, inside, fast and slow.
                let at = Vector3::new(next(), next(), next()) * 2.0;
                let query = query(at, Vector3::new(next(), next(), next()));
                let scalar = Path::Scalar.run(&constants, &query, set.blocks());
                let portable = Path::Portable.run(&constants, &query, set.blocks());
                let best = Path::best().run(&constants, &query, set.blocks());
                assert!(bits(&scalar).iter().all(|b| f64::from_bits(*b).is_finite()));
                assert_eq!(bits(&scalar), bits(&portable));
                assert_eq!(bits(&scalar), bits(&best));
            }
        }
    }

    #[test]
    fn the_kernel_is_the_published_formula() {
        let mut set = ObstacleSet::with_capacity(1);
        set.add(Obstacle::sphere(Vector3::zeros(), 0.1)).unwrap();
        let query = query(Vector3::new(0.0, 0.0, 0.25), Vector3::new(0.0, 0.2, -0.03));
        let sum = Path::best().run(&Constants::new(&P), &query, set.blocks());
        let (x, xd): (f64, f64) = (0.1, -0.03);
        let s = 1.0 - 1.0 / (1.0 + libm::exp(-xd / 0.01));
        let g = (1.0 - x / 0.5) * (1.0 - x / 0.5);
        let a = 800.0 * libm::exp(-x / 0.01) - 50.0 * s * xd / (x / 0.04 + 0.01);
        let weight = s * g * 1e4 / (x / 0.02 + 0.001);
        assert!((sum.clearance - x).abs() < 1e-15);
        assert!((sum.metric[(2, 2)] / weight - 1.0).abs() < 1e-13);
        assert!((sum.force.z / (weight * (a - 0.1)) - 1.0).abs() < 1e-13);
        assert_eq!(sum.metric[(0, 0)], 0.0);
    }
}
