//! Points that fill the unit cube evenly: the Halton sequence (1960).

/// The first primes, a base for each dimension.
// As many as a body has joints at most.
const PRIMES: [u64; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];

/// Number `index` of the sequence in dimension `dimension`, in [0, 1).
pub(crate) fn value(index: u64, dimension: usize) -> f64 {
    let base = PRIMES[dimension % PRIMES.len()];
    let (mut rest, mut scale, mut sum) = (index, 1.0, 0.0);
    while rest > 0 {
        scale /= base as f64;
        sum += scale * (rest % base) as f64;
        rest /= base;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn the_first_numbers_are_the_published_ones() {
        let halves: Vec<f64> = (1..5).map(|index| value(index, 0)).collect();
        assert_eq!(halves, [0.5, 0.25, 0.75, 0.125]);
        assert!((value(2, 1) - 2.0 / 3.0).abs() < 1e-15);
    }
}
