//! Speed of simulated time.

use std::collections::VecDeque;

/// Length of the window (ns).
const WINDOW_NS: u64 = 1_000_000_000;
/// Largest number of samples.
// Two a frame for a second; more would only cost memory.
const MAX_SAMPLES: usize = 128;

/// Simulated seconds per second, over the last second.
#[derive(Clone, Debug, Default)]
pub struct RealTimeFactor {
    samples: VecDeque<(u64, u64)>,
}

impl RealTimeFactor {
    /// Adds a sample of the wall clock and the simulated one (ns); returns the speed of the
    /// second by the first.
    pub fn sample(&mut self, now_ns: u64, sim_ns: u64) -> f64 {
        // Without this the difference below would be negative.
        if self.samples.back().is_some_and(|(_, last)| sim_ns < *last) {
            // The scene was reset.
            self.samples.clear();
        }
        self.samples.push_back((now_ns, sim_ns));
        let old = |sample: Option<&(u64, u64)>| sample.is_some_and(|l| l.0 + WINDOW_NS <= now_ns);
        // The sample before the window stays, so that the window is full.
        while self.samples.len() > MAX_SAMPLES || old(self.samples.get(1)) {
            self.samples.pop_front();
        }
        let (start_ns, start_sim_ns) = self.samples.front().copied().unwrap_or((now_ns, sim_ns));
        // The first sample has no difference.
        if now_ns <= start_ns {
            return 0.0;
        }
        (sim_ns - start_sim_ns) as f64 / (now_ns - start_ns) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::RealTimeFactor;

    #[test]
    fn half_speed_is_seen_and_a_reset_is_no_negative_speed() {
        let mut meter = RealTimeFactor::default();
        let mut factor = 0.0;
        for sample in 0..200_u64 {
            factor = meter.sample(sample * 16_000_000, sample * 8_000_000);
        }
        assert_eq!(factor, 0.5);
        assert_eq!(meter.sample(200 * 16_000_000, 0), 0.0);
        assert_eq!(meter.sample(201 * 16_000_000, 16_000_000), 1.0);
    }
}
