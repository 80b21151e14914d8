//! Growth of a cost with a size.

/// Sizes below this share of the largest are left out: constant parts of the cost and noise
/// hide its growth.
const SMALLEST_SHARE: f64 = 0.1;
/// Growth that is less than this share of the cost at size 0 may be noise.
pub(super) const LEAST_GROWTH: f64 = 0.05;

/// The exponent k of `cost(n) - cost(0) = b n^k`, by least squares of the logarithms, and the
/// number of sizes used; `costs` are sizes with their costs, including size 0. `None` if fewer
/// than two sizes cost [`LEAST_GROWTH`] more than size 0.
pub(super) fn exponent(costs: &[(usize, f64)]) -> Option<(f64, usize)> {
    let (_, base) = *costs.iter().find(|(size, _)| *size == 0)?;
    let largest = costs.iter().map(|(size, _)| *size).max()? as f64;
    let points: Vec<(f64, f64)> = costs
        .iter()
        .map(|(size, cost)| (*size as f64, cost - base))
        // Growth of 0 has no logarithm.
        .filter(|(size, growth)| *size >= SMALLEST_SHARE * largest && *growth > LEAST_GROWTH * base)
        .map(|(size, growth)| (size.ln(), growth.ln()))
        .collect();
    let slope = slope(&points)?;
    Some((slope, points.len()))
}

/// Least squares; `None` for points that are one above the other.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let count = points.len() as f64;
    let mean_x = points.iter().map(|(x, _)| x).sum::<f64>() / count;
    let mean_y = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let rise: f64 = points
        .iter()
        .map(|(x, y)| (x - mean_x) * (y - mean_y))
        .sum();
    let run: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    (run > 0.0).then(|| rise / run)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(sizes: &[usize], cost: impl Fn(f64) -> f64) -> Option<(f64, usize)> {
        let costs = sizes.iter().map(|size| (*size, cost(*size as f64)));
        exponent(&costs.collect::<Vec<_>>())
    }

    #[test]
    fn the_exponent_is_that_of_what_grows() {
        for power in [0.5, 1.0, 1.5, 2.0] {
            let (found, _) = of(&[0, 8, 16, 32, 64], |n| 40.0 + 3.0 * n.powf(power)).unwrap();
            assert!((found - power).abs() < 1.0e-9, "{found} for {power}");
        }
    }

    #[test]
    fn a_cost_that_does_not_grow_has_none() {
        assert_eq!(of(&[0, 8, 16, 32], |_| 40.0), None);
        assert_eq!(of(&[0, 8, 16, 32], |n| 40.0 + 0.01 * n), None);
        assert_eq!(of(&[8, 16, 32], |n| n), None, "without size 0");
        assert_eq!(of(&[0, 8], |n| n), None, "of one size");
    }

    #[test]
    fn small_sizes_are_left_out() {
        let (_, sizes) = of(&[0, 1, 2, 50, 100], |n| 10.0 + n).unwrap();
        assert_eq!(sizes, 2);
    }
}
