//! The state hash: 64 bits that are equal for equal runs.

/// Mixes numbers word by word, with the finaliser of `SplitMix64` after each.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateHash(u64);

impl StateHash {
    /// Starts with the tick.
    pub(crate) fn new(tick: u64) -> Self {
        let mut hash = Self(0x9e37_79b9_7f4a_7c15);
        hash.word(tick);
        hash
    }

    fn word(&mut self, word: u64) {
        let mut z = (self.0 ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = z ^ (z >> 31);
    }

    /// Adds numbers by their bits.
    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.word(number.to_bits());
        }
    }

    /// The hash of everything added so far.
    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::StateHash;

    fn hash(tick: u64, numbers: &[f64]) -> u64 {
        let mut hash = StateHash::new(tick);
        hash.numbers(numbers);
        hash.finish()
    }

    #[test]
    fn order_tick_and_the_last_bit_count() {
        let base = hash(1, &[1.0, 2.0]);
        assert_eq!(base, hash(1, &[1.0, 2.0]));
        for other in [
            hash(2, &[1.0, 2.0]),
            hash(1, &[2.0, 1.0]),
            hash(1, &[1.0, 2.0 + 4.5e-16]),
        ] {
            assert_ne!(base, other);
        }
    }
}
