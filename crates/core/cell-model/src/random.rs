//! The random numbers of a run: `SplitMix64` (Steele, Lea and Flood, "Fast splittable
//! pseudorandom number generators", 2014). It is small, and the same on every machine.

/// A generator; equal seeds give equal numbers.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// A generator for `seed`.
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly distributed from 0 up to, but without, 1, with 53 random bits.
    pub fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly distributed from `-half` to `half`, with 53 random bits.
    pub fn around_zero(&mut self, half: f64) -> f64 {
        half * (2.0 * self.share() - 1.0)
    }

    /// A number below `end`; 0 where that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        // The remainder prefers small numbers, but by less than `end` / 2^64.
        let rest = self.bits() % (end as u64).max(1);
        usize::try_from(rest).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_sequence_of_seed_zero() {
        let mut random = Random::new(0);
        assert_eq!(random.bits(), 0xe220_a839_7b1d_cdaf);
        assert_eq!(random.bits(), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn numbers_stay_within_bounds_and_reach_both_sides() {
        let mut random = Random::new(7);
        let values: Vec<f64> = (0..1000).map(|_| random.around_zero(0.02)).collect();
        assert!(values.iter().all(|v| v.abs() <= 0.02));
        assert!(values.iter().any(|v| *v > 0.015) && values.iter().any(|v| *v < -0.015));
    }
}
