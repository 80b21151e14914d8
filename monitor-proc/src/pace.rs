//! Speed of simulated time.

use std::collections::VecDeque;

/// Length of the window (ns).
const WINDOW_NS: u64 = 1_000_000_000;
/// Largest number of samples.
// Two a frame for a second; more would only cost memory.
const MAX_LOOKS: usize = 128;

/// Simulated seconds per second, over the last second.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    looks: VecDeque<(u64, u64)>,
}

impl Pace {
    /// Adds a sample of the wall clock and the simulated one (ns); returns the speed of the
    /// second by the first.
    pub fn look(&mut self, now_ns: u64, sim_ns: u64) -> f64 {
        // Without this the difference below would be negative.
        if self.looks.back().is_some_and(|(_, last)| sim_ns < *last) {
            // The scene was reset.
            self.looks.clear();
        }
        self.looks.push_back((now_ns, sim_ns));
        let old = |look: Option<&(u64, u64)>| look.is_some_and(|l| l.0 + WINDOW_NS <= now_ns);
        // The sample before the window stays, so that the window is full.
        while self.looks.len() > MAX_LOOKS || old(self.looks.get(1)) {
            self.looks.pop_front();
        }
        let (began_ns, began_sim_ns) = self.looks.front().copied().unwrap_or((now_ns, sim_ns));
        // The first sample has no difference.
        if now_ns <= began_ns {
            return 0.0;
        }
        (sim_ns - began_sim_ns) as f64 / (now_ns - began_ns) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::Pace;

    #[test]
    fn half_speed_is_seen_and_a_reset_is_no_negative_speed() {
        let mut pace = Pace::default();
        let mut factor = 0.0;
        for look in 0..200_u64 {
            factor = pace.look(look * 16_000_000, look * 8_000_000);
        }
        assert_eq!(factor, 0.5);
        assert_eq!(pace.look(200 * 16_000_000, 0), 0.0);
        assert_eq!(pace.look(201 * 16_000_000, 16_000_000), 1.0);
    }
}
