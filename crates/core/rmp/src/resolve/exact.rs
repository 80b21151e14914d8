//! The published resolve: `a = M^-1 f`, or, where its norm exceeds the trust
//! region, `a = (M + lambda I)^-1 f` with `lambda` such that the norm equals it.

use nalgebra::{DMatrix, DVector};

use super::cholesky::Cholesky;

/// Relative accuracy of the norm on the trust region; rounding is near 1e-15.
const TOLERANCE: f64 = 1e-12;
// Newton needs a few; the bound ends the loop where rounding stops the progress.
const MOST_ITERATIONS: usize = 100;

/// Result of a resolve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The solution is within the trust region.
    Free,
    /// The solution was shortened onto the trust region.
    Shortened,
    /// The metric is not positive definite: the solution is zero acceleration.
    Singular,
}

/// Writes the acceleration for `metric` and `force` to `out`.
pub(crate) fn resolve(
    factor: &mut Cholesky,
    scratch: &mut [f64],
    metric: &DMatrix<f64>,
    force: &DVector<f64>,
    radius: f64,
    out: &mut [f64],
) -> Outcome {
    out.copy_from_slice(force.as_slice());
    if !factor.factor(metric, 0.0) {
        out.fill(0.0);
        return Outcome::Singular;
    }
    factor.solve(out);
    let mut length = norm(out);
    // The published resolve shortens only what exceeds the trust region.
    if length <= radius {
        return Outcome::Free;
    }
    // Newton on 1/radius - 1/|a(lambda)|, which is nearly linear (More and
    // Sorensen 1983): from lambda = 0 it rises to the root without overshoot.
    let mut lambda = 0.0;
    for _ in 0..MOST_ITERATIONS {
        scratch.copy_from_slice(out);
        factor.solve_lower(scratch);
        let slope = norm(scratch);
        let ratio = length / slope;
        lambda += ratio * ratio * (length - radius) / radius;
        if !factor.factor(metric, lambda) {
            out.fill(0.0);
            return Outcome::Singular;
        }
        out.copy_from_slice(force.as_slice());
        factor.solve(out);
        length = norm(out);
        if (length / radius - 1.0).abs() <= TOLERANCE {
            break;
        }
    }
    Outcome::Shortened
}

fn norm(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |sum, v| sum + v * v).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(force: [f64; 2], radius: f64) -> (Outcome, [f64; 2]) {
        let metric = DMatrix::from_row_slice(2, 2, &[100.0, 3.0, 3.0, 1.0]);
        let mut out = [0.0; 2];
        let outcome = resolve(
            &mut Cholesky::new(2),
            &mut [0.0; 2],
            &metric,
            &DVector::from_row_slice(&force),
            radius,
            &mut out,
        );
        (outcome, out)
    }

    #[test]
    fn a_short_answer_is_the_plain_solution() {
        let (outcome, a) = case([103.0, 4.0], 50.0);
        assert_eq!(outcome, Outcome::Free);
        assert!((a[0] - 1.0).abs() < 1e-14 && (a[1] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_long_answer_meets_the_radius_and_turns_towards_the_stiff_axis() {
        let (outcome, a) = case([1000.0, 1000.0], 50.0);
        assert_eq!(outcome, Outcome::Shortened);
        assert!((a[0].hypot(a[1]) - 50.0).abs() < 1e-9);
        let (_, plain) = case([1000.0, 1000.0], 1e9);
        assert!((a[0] / a[1] - plain[0] / plain[1]).abs() > 1e-3);
    }
}
