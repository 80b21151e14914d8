//! Statistics of two outcomes.

use cell_model::random::Random;

/// Of the normal distribution, for 95 %.
const Z: f64 = 1.959_963_984_540_054;
/// Samples of a bootstrap.
const SAMPLES: usize = 2_000;

/// The interval that holds the rate of `done` of `all` with 95 % (Wilson 1927), 0 to 1.
pub fn wilson(done: u64, all: u64) -> (f64, f64) {
    if all == 0 {
        return (0.0, 1.0);
    }
    let (n, p) = (all as f64, done as f64 / all as f64);
    // Not the interval of the normal distribution, which has no length where all or none are done.
    let middle = (p + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
    ((middle - half).max(0.0), (middle + half).min(1.0))
}

/// How likely two equal ways differ as much on the same seeds, where `one` seeds ended done
/// only the one way and `other` only the other way: the exact test of `McNemar`, two-sided.
pub fn mcnemar(one: u64, other: u64) -> f64 {
    let all = one + other;
    // Sum of the binomial distribution of a fair coin, in logarithms: 2^-n is 0 in double
    // precision from about 1,075 pairs on.
    let mut log = -(all as f64) * std::f64::consts::LN_2;
    let mut sum = log.exp();
    for k in 1..=one.min(other) {
        log += ((all - k + 1) as f64 / k as f64).ln();
        sum += log.exp();
    }
    // With equal counts both tails contain the middle, and the sum exceeds 1.
    (2.0 * sum).min(1.0)
}

/// How likely two equal rates differ as much in independent samples of `one` and `other`
/// (done, all): the test of two proportions with the pooled rate, two-sided.
pub fn two_proportions(one: (u64, u64), other: (u64, u64)) -> f64 {
    let (n, m) = (one.1 as f64, other.1 as f64);
    let pooled = (one.0 + other.0) as f64 / (n + m);
    let error = (pooled * (1.0 - pooled) * (1.0 / n + 1.0 / m)).sqrt();
    // All or none of both are done, or a sample is empty: nothing to be tested.
    if error <= 0.0 || !error.is_finite() {
        return 1.0;
    }
    let z = (one.0 as f64 / n - other.0 as f64 / m).abs() / error;
    erfc(z / std::f64::consts::SQRT_2)
}

/// The complementary error function, within 1.2e-7 (Numerical Recipes, `erfcc`).
fn erfc(x: f64) -> f64 {
    const C: [f64; 10] = [
        -1.265_512_23,
        1.000_023_68,
        0.374_091_96,
        0.096_784_18,
        -0.186_288_06,
        0.278_868_07,
        -1.135_203_98,
        1.488_515_87,
        -0.822_152_23,
        0.170_872_77,
    ];
    let t = 1.0 / (1.0 + 0.5 * x);
    let sum = C.iter().rev().fold(0.0, |sum, c| sum * t + c);
    t * (sum - x * x).exp()
}

/// The interval that holds the mean of `values` with 95 %, by resampling them; the same for the
/// same values. `None` without any.
pub fn bootstrap(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let mut random = Random::new(1);
    let mut pick = || {
        let place = (random.around_zero(0.5) + 0.5) * values.len() as f64;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place of the list"
        )]
        values[(place as usize).min(values.len() - 1)]
    };
    let mut means: Vec<f64> = (0..SAMPLES)
        .map(|_| (0..values.len()).map(|_| pick()).sum::<f64>() / values.len() as f64)
        .collect();
    means.sort_by(f64::total_cmp);
    Some((quantile(&means, 0.025), quantile(&means, 0.975)))
}

/// The least of sorted values, at least one, that `part` (0 to 1) of them do not exceed.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place of the list"
    )]
    let rank = (part * sorted.len() as f64).ceil() as usize;
    sorted
        .get(rank.saturating_sub(1))
        .copied()
        .unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
    }

    #[test]
    fn intervals_and_tests_have_the_published_values() {
        // Wilson: Newcombe 1998, table I.
        let (low, high) = wilson(81, 263);
        near(low, 0.2553);
        near(high, 0.3662);
        let (low, high) = wilson(0, 20);
        near(low, 0.0);
        near(high, 0.1611);
        assert_eq!(wilson(0, 0), (0.0, 1.0));
        // Exact binomial: 2 P(X <= 2), X of 12 fair coins.
        near(mcnemar(2, 10), 0.0386);
        near(mcnemar(10, 2), 0.0386);
        near(mcnemar(0, 0), 1.0);
        near(mcnemar(5, 5), 1.0);
        assert!(mcnemar(0, 5_000) < 1e-100);
        // z = 1.9600.
        near(erfc(Z / std::f64::consts::SQRT_2), 0.05);
        near(two_proportions((50, 50), (50, 50)), 1.0);
        assert!(two_proportions((970, 1_000), (1_000, 1_000)) < 1e-6);
    }

    #[test]
    fn a_bootstrap_holds_the_mean() {
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let (low, high) = bootstrap(&values).unwrap();
        // The standard error is 2.89.
        assert!(
            (low - 43.9).abs() < 1.0 && (high - 55.1).abs() < 1.0,
            "{low} {high}"
        );
        assert_eq!(bootstrap(&[]), None);
    }
}
