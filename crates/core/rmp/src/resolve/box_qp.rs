//! `min (a - a*)^T M (a - a*)` with `lower <= a <= upper`, `a* = M^-1 f`: a
//! strictly convex box problem, solved exactly by block principal pivoting
//! (Judice and Pires 1994) with Murty's single pivots as the safeguard that makes
//! it finite.

use nalgebra::{DMatrix, DVector};

use super::cholesky::Cholesky;

/// Position of a coordinate with respect to its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Free,
    Lower,
    Upper,
}

/// Preallocated solver; the active bounds are the start of the next call.
// From one cycle to the next they rarely change, so one solve is usually enough. They are part
// of the checkpoint: another start may end with other last bits.
#[derive(Debug, Clone)]
pub(crate) struct BoxQp {
    sides: Vec<Side>,
    free: Vec<usize>,
    solution: Vec<f64>,
    factor: Cholesky,
}

/// Block exchanges without progress before single pivots start.
// Block exchanges are fast but may cycle; single pivots always end.
const PATIENCE: usize = 3;

impl BoxQp {
    pub(crate) fn new(joints: usize) -> Self {
        Self {
            sides: vec![Side::Free; joints],
            free: Vec::with_capacity(joints),
            solution: vec![0.0; joints],
            factor: Cholesky::new(joints),
        }
    }

    /// The coordinates at their lower and at their upper bound, bit by bit.
    pub(crate) fn active_bounds(&self) -> (u64, u64) {
        let at = |bound: Side| {
            let sides = self.sides.iter().enumerate();
            sides.fold(0, |bits, (i, place)| bits | u64::from(*place == bound) << i)
        };
        (at(Side::Lower), at(Side::Upper))
    }

    /// Sets the start of the next call.
    pub(crate) fn set_active_bounds(&mut self, lower: u64, upper: u64) {
        for (i, place) in self.sides.iter_mut().enumerate() {
            *place = match (lower >> i & 1, upper >> i & 1) {
                (1, _) => Side::Lower,
                (_, 1) => Side::Upper,
                _ => Side::Free,
            };
        }
    }

    /// Writes the minimiser to `out`. Returns `false` if the metric is not positive definite,
    /// or no solution was found in a bounded number of steps; `out` is then the point of the
    /// box nearest to zero.
    pub(crate) fn solve(
        &mut self,
        metric: &DMatrix<f64>,
        force: &DVector<f64>,
        lower: &[f64],
        upper: &[f64],
        out: &mut [f64],
    ) -> bool {
        let n = out.len();
        let mut fewest = n + 1;
        let mut patience = PATIENCE;
        // In theory single pivots could take long; in practice 2 to 5 steps are enough.
        for _ in 0..(8 * n + 20) {
            if !self.solve_free(metric, force, lower, upper, out) {
                break;
            }
            let (wrong, last) = self.count_wrong(metric, force, lower, upper, out);
            if wrong == 0 {
                // Rounding may leave a free coordinate beyond its bound by the margin.
                for ((a, &low), &high) in out.iter_mut().zip(lower).zip(upper) {
                    *a = a.max(low).min(high);
                }
                return true;
            }
            // Progress: exchange all wrong coordinates at once, and allow some exchanges
            // without any.
            if wrong < fewest {
                fewest = wrong;
                patience = PATIENCE;
                self.exchange(metric, force, lower, upper, out, 0);
            } else if patience > 0 {
                patience -= 1;
                self.exchange(metric, force, lower, upper, out, 0);
            } else {
                self.exchange(metric, force, lower, upper, out, last);
            }
        }
        // The next call starts free of the bounds that gave no solution.
        self.sides.fill(Side::Free);
        for ((a, &low), &high) in out.iter_mut().zip(lower).zip(upper) {
            *a = 0.0_f64.max(low).min(high);
        }
        false
    }

    /// Solves the free coordinates with the others at their bounds.
    fn solve_free(
        &mut self,
        metric: &DMatrix<f64>,
        force: &DVector<f64>,
        lower: &[f64],
        upper: &[f64],
        out: &mut [f64],
    ) -> bool {
        self.free.clear();
        for (i, place) in self.sides.iter().enumerate() {
            match place {
                Side::Free => self.free.push(i),
                Side::Lower => out[i] = lower[i],
                Side::Upper => out[i] = upper[i],
            }
        }
        if !self.factor.factor_block(metric, &self.free) {
            return false;
        }
        let x = &mut self.solution[..self.free.len()];
        for (value, &i) in x.iter_mut().zip(&self.free) {
            // The coordinates at their bounds are known; they move to the right-hand side.
            let mut rest = force[i];
            for (j, place) in self.sides.iter().enumerate() {
                if *place != Side::Free {
                    rest -= metric[(i, j)] * out[j];
                }
            }
            *value = rest;
        }
        self.factor.solve(x);
        for (&value, &i) in x.iter().zip(&self.free) {
            out[i] = value;
        }
        true
    }

    /// Number of coordinates on the wrong side of a bound, and the last of them.
    fn count_wrong(
        &self,
        metric: &DMatrix<f64>,
        force: &DVector<f64>,
        lower: &[f64],
        upper: &[f64],
        a: &[f64],
    ) -> (usize, usize) {
        let mut wrong = (0, 0);
        for i in 0..a.len() {
            if self.better(metric, force, lower, upper, a, i) != self.sides[i] {
                wrong = (wrong.0 + 1, i);
            }
        }
        wrong
    }

    fn exchange(
        &mut self,
        metric: &DMatrix<f64>,
        force: &DVector<f64>,
        lower: &[f64],
        upper: &[f64],
        a: &[f64],
        from: usize,
    ) {
        for i in from..a.len() {
            self.sides[i] = self.better(metric, force, lower, upper, a, i);
        }
    }

    /// The side of coordinate `i`, by its bounds and its multiplier.
    fn better(
        &self,
        metric: &DMatrix<f64>,
        force: &DVector<f64>,
        lower: &[f64],
        upper: &[f64],
        a: &[f64],
        i: usize,
    ) -> Side {
        match self.sides[i] {
            Side::Free if a[i] < lower[i] - margin(lower[i]) => Side::Lower,
            Side::Free if a[i] > upper[i] + margin(upper[i]) => Side::Upper,
            Side::Free => Side::Free,
            bound => {
                let column = metric.column(i);
                let mut pull = force[i];
                let mut scale = pull.abs();
                for (m, x) in column.iter().zip(a) {
                    pull -= m * x;
                    scale += (m * x).abs();
                }
                // Rounding must not free a coordinate that belongs to its bound.
                let inward = if bound == Side::Upper { -pull } else { pull };
                if inward > 1e-13 * scale {
                    Side::Free
                } else {
                    bound
                }
            }
        }
    }
}

fn margin(bound: f64) -> f64 {
    1e-13 * (1.0 + bound.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pseudo_random(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    /// The optimum is where no allowed move of one coordinate lowers the cost.
    fn assert_optimal(m: &DMatrix<f64>, f: &DVector<f64>, low: &[f64], high: &[f64], a: &[f64]) {
        let gradient = m * DVector::from_row_slice(a) - f;
        for i in 0..a.len() {
            let tolerance = 1e-8 * (1.0 + f.amax());
            assert!(a[i] >= low[i] && a[i] <= high[i]);
            if a[i] > low[i] {
                assert!(gradient[i] < tolerance, "{i}: {}", gradient[i]);
            }
            if a[i] < high[i] {
                assert!(gradient[i] > -tolerance, "{i}: {}", gradient[i]);
            }
        }
    }

    #[test]
    fn random_problems_of_many_sizes_are_solved_to_optimality() {
        let mut seed = 1;
        for n in [1, 2, 7, 16, 64] {
            let mut qp = BoxQp::new(n);
            for _ in 0..60 {
                let b = DMatrix::from_fn(n, n, |_, _| pseudo_random(&mut seed));
                let m = &b * b.transpose() * 1e4 + DMatrix::identity(n, n) * 0.5;
                let f = DVector::from_fn(n, |_, _| 1e5 * pseudo_random(&mut seed));
                let low: Vec<f64> = (0..n).map(|_| 6.0 * pseudo_random(&mut seed)).collect();
                let high: Vec<f64> = low.iter().map(|l| l + 2.0).collect();
                let mut a = vec![0.0; n];
                assert!(qp.solve(&m, &f, &low, &high, &mut a), "n = {n}");
                assert_optimal(&m, &f, &low, &high, &a);
            }
        }
    }

    #[test]
    fn a_box_of_no_width_fixes_the_answer() {
        let mut qp = BoxQp::new(2);
        let mut a = [0.0; 2];
        let m = DMatrix::identity(2, 2);
        let f = DVector::from_row_slice(&[5.0, 0.3]);
        assert!(qp.solve(&m, &f, &[1.0, -1.0], &[1.0, 1.0], &mut a));
        assert_eq!(a[0], 1.0);
        assert!((a[1] - 0.3).abs() < 1e-15);
    }
}
