//! Latency histogram of fixed size: recording allocates nothing and costs a
//! few instructions.

/// Steps per factor of two: a value is known to 1/64, which is 1.6 %.
// Two digits are what a report prints; 64 steps fit 2,368 counters into 9 KiB.
const STEP_BITS: u32 = 6;
const STEPS: u64 = 1 << STEP_BITS;
/// Factors of two above the exact range; the last step ends near 73 minutes.
const OCTAVES: usize = 36;
const BUCKETS: usize = (1 << STEP_BITS) * (OCTAVES + 1);

/// Counts of durations in nanoseconds. Exact below 64 ns, within 1.6 % up to
/// an hour; longer ones count as the longest. The maximum is exact.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u32; BUCKETS]>,
    count: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self::new()
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the shift leaves a number of buckets"
)]
fn bucket_of(value: u64) -> usize {
    if value < STEPS {
        return value as usize;
    }
    // Values of [2^b, 2^(b+1)) share an octave of STEPS buckets.
    let shift = value.ilog2() - STEP_BITS;
    let step = (value >> shift) - STEPS;
    let bucket = STEPS * (u64::from(shift) + 1) + step;
    (bucket as usize).min(BUCKETS - 1)
}

// The end of a bucket, not its middle: a percentile must not look better than it was.
fn highest_of(bucket: usize) -> u64 {
    let bucket = bucket as u64;
    if bucket < STEPS {
        return bucket;
    }
    let shift = bucket / STEPS - 1;
    (((bucket % STEPS) + STEPS + 1) << shift) - 1
}

impl Histogram {
    /// An empty histogram; the only place that allocates.
    pub fn new() -> Self {
        Self {
            counts: Box::new([0; BUCKETS]),
            count: 0,
            max: 0,
        }
    }

    /// Counts one duration.
    #[inline]
    pub fn record(&mut self, duration_ns: u64) {
        let count = &mut self.counts[bucket_of(duration_ns)];
        // Saturating: a count that stops growing misleads less than one that starts again at 0.
        *count = count.saturating_add(1);
        self.count += 1;
        self.max = self.max.max(duration_ns);
    }

    /// Durations counted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The longest, nanoseconds; 0 when empty.
    pub fn max(&self) -> u64 {
        self.max
    }

    /// The smallest duration that at least `percent` (0 to 100) of all do not
    /// exceed, rounded up to the bucket's end; 0 when empty.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float that is too large or negative becomes the nearest rank"
    )]
    pub fn percentile(&self, percent: f64) -> u64 {
        let wanted = (percent / 100.0 * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (bucket, count) in self.counts.iter().enumerate() {
            seen += u64::from(*count);
            if seen >= wanted {
                return highest_of(bucket).min(self.max);
            }
        }
        self.max
    }

    /// Buckets that are not empty, in ascending order: the longest duration of the bucket
    /// (ns), and how many are in it.
    pub fn buckets(&self) -> impl Iterator<Item = (u64, u64)> {
        let filled = self
            .counts
            .iter()
            .enumerate()
            .filter(|(_, count)| **count > 0);
        filled.map(|(bucket, count)| (highest_of(bucket).min(self.max), u64::from(*count)))
    }

    /// Back to empty.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        self.count = 0;
        self.max = 0;
    }

    /// Adds the counts of another histogram.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.counts.iter_mut().zip(other.counts.iter()) {
            *mine = mine.saturating_add(*theirs);
        }
        self.count += other.count;
        self.max = self.max.max(other.max);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_within_two_percent_over_nine_decades() {
        for scale in [1_u64, 1_000, 1_000_000, 1_000_000_000] {
            let mut histogram = Histogram::new();
            for value in 1..=1000 {
                histogram.record(value * scale);
            }
            for percent in [1.0, 50.0, 99.0, 99.9] {
                let exact = percent * 10.0 * scale as f64;
                let found = histogram.percentile(percent) as f64;
                assert!(
                    found >= exact && found <= exact * 1.02 + 1.0,
                    "{found} for {exact}"
                );
            }
            assert_eq!(histogram.max(), 1000 * scale);
        }
    }

    #[test]
    fn every_value_lies_in_its_bucket() {
        for bits in 0..42 {
            for value in [1_u64 << bits, (1 << bits) + 1, (2 << bits) - 1] {
                let bucket = bucket_of(value);
                assert!(value <= highest_of(bucket));
                assert!(bucket == 0 || value > highest_of(bucket - 1));
            }
        }
    }

    #[test]
    fn absurd_and_missing_values_do_no_harm() {
        let mut histogram = Histogram::new();
        assert_eq!(histogram.percentile(99.0), 0);
        histogram.record(u64::MAX);
        assert_eq!(histogram.max(), u64::MAX);
        histogram.clear();
        assert_eq!((histogram.count(), histogram.max()), (0, 0));
    }

    #[test]
    fn merging_is_recording_both() {
        let (mut a, mut b, mut both) = (Histogram::new(), Histogram::new(), Histogram::new());
        for value in 0..500 {
            a.record(value * 7);
            b.record(value * value);
            both.record(value * 7);
            both.record(value * value);
        }
        a.merge(&b);
        assert_eq!(a.count(), both.count());
        assert_eq!(a.percentile(90.0), both.percentile(90.0));
    }
}
