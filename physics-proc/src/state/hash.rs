//! The state hash: 64 bits that are equal for equal runs.

/// Odd, with bits set all over: the fraction of the golden ratio.
const KEY: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes groups of numbers one after the other, each with the finaliser of `SplitMix64`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StateHash(u64);

impl StateHash {
    /// Starts with the tick.
    pub(crate) fn new(tick: u64) -> Self {
        let mut hash = Self(KEY);
        hash.word(tick);
        hash
    }

    fn word(&mut self, word: u64) {
        let mut z = (self.0 ^ word).wrapping_add(KEY);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        self.0 = z ^ (z >> 31);
    }

    /// Adds a group of numbers by their bits. Each pair of them is multiplied with keys of
    /// its own and the product folded (as wyhash does): no product waits for another one.
    pub(crate) fn numbers(&mut self, numbers: &[f64]) {
        let mut sum = numbers.len() as u64;
        let mut key = KEY;
        for pair in numbers.chunks(2) {
            let [a, b] = [pair.first(), pair.get(1)].map(|x| x.map_or(0, |x| x.to_bits()));
            sum = sum.wrapping_add(folded(a ^ key, b ^ key.rotate_left(32)));
            key = key.wrapping_add(KEY << 1);
        }
        self.word(sum);
    }

    /// The hash of everything added so far.
    pub(crate) fn finish(self) -> u64 {
        self.0
    }
}

/// Both halves of a product.
#[expect(clippy::cast_possible_truncation, reason = "the lower half")]
fn folded(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    product as u64 ^ (product >> 64) as u64
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
            hash(1, &[1.0, 2.0, 0.0]),
            hash(1, &[1.0]),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn the_last_bit_of_each_of_many_numbers_counts() {
        let numbers = [0.25; 13];
        let base = hash(1, &numbers);
        let mut seen = vec![base];
        for place in 0..numbers.len() {
            for bit in 0..64 {
                let mut other = numbers;
                other[place] = f64::from_bits(other[place].to_bits() ^ (1 << bit));
                seen.push(hash(1, &other));
            }
        }
        let count = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), count);
    }
}
