//! Changes to valid inputs, for the short run in the tests: it does not replace the hours of a
//! fuzzer with coverage.

/// A generator of equal sequences for equal seeds (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `limit`; 0 for a limit of 0.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        usize::try_from(self.next() % (limit.max(1) as u64)).unwrap_or(0)
    }
}

/// Replacements for a number.
const VALUES: [&str; 20] = [
    "nan",
    "inf",
    "-inf",
    ".nan",
    "-1",
    "0",
    "-0.0",
    "0.5",
    "1e308",
    "-1e308",
    "1e-308",
    "1e999",
    "9999999999999999999999",
    "4294967296",
    "1000000",
    "\"x\"",
    "[]",
    "{}",
    "true",
    "null",
];

/// `input` with one to four changes.
pub(crate) fn mutated(input: &[u8], others: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..=random.below(4) {
        change(&mut bytes, others, random);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, others: &[Vec<u8>], random: &mut Random) {
    let at = random.below(bytes.len());
    match random.below(8) {
        0 | 1 => replace_number(bytes, random),
        2 => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte ^= 1 << random.below(8);
            }
        }
        3 => bytes.truncate(at),
        4 => {
            let end = (at + random.below(64)).min(bytes.len());
            bytes.drain(at..end);
        }
        5 => {
            let end = (at + random.below(200)).min(bytes.len());
            let again = bytes.get(at..end).unwrap_or_default().to_vec();
            bytes.splice(at..at, again);
        }
        6 => {
            let other = others.get(random.below(others.len()));
            let other = other.map(Vec::as_slice).unwrap_or_default();
            let from = random.below(other.len());
            let to = (from + random.below(100)).min(other.len());
            bytes.splice(at..at, other[from..to].iter().copied());
        }
        _ => {
            let noise: Vec<u8> = (0..random.below(16))
                .map(|_| random.next().to_le_bytes()[0])
                .collect();
            bytes.splice(at..at, noise);
        }
    }
}

/// Replaces the digits from some position on.
fn replace_number(bytes: &mut Vec<u8>, random: &mut Random) {
    let from = random.below(bytes.len());
    let is_number = |byte: &u8| byte.is_ascii_digit() || b"+-.e".contains(byte);
    let digit = |byte: &u8| byte.is_ascii_digit();
    let Some(start) = bytes.iter().skip(from).position(digit) else {
        return;
    };
    let start = from + start;
    let length = bytes[start..]
        .iter()
        .take_while(|byte| is_number(byte))
        .count();
    let value = VALUES[random.below(VALUES.len())];
    bytes.splice(start..start + length, value.bytes());
}
