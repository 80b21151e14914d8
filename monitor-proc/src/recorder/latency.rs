//! Latency of one hop over the last seconds.

use cell_rt::Histogram;
use serde::Serialize;

/// Half of the window (ns).
const HALF_NS: u64 = 5_000_000_000;
/// Upper ends of the buckets (us).
const EDGES_US: [u64; 20] = [
    10, 20, 50, 100, 150, 200, 300, 500, 700, 1000, 1500, 2000, 3000, 5000, 10_000, 20_000, 50_000,
    100_000, 1_000_000, 10_000_000,
];

/// Latency of one hop, of the last five to ten seconds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HopLatency {
    /// `state to command`, `command to drives`, `state to decision` or
    /// `decision to controller`.
    pub hop: &'static str,
    /// The arm; `None` for a hop without one.
    pub arm: Option<u8>,
    /// Number of measurements.
    pub n: u64,
    /// Median (us).
    pub p50_us: f64,
    /// 99th percentile (us).
    pub p99_us: f64,
    /// 99.9th percentile (us).
    pub p999_us: f64,
    /// Longest (us).
    pub max_us: f64,
    /// Upper end (us) and count of each bucket that is not empty.
    pub buckets: Vec<(u64, u64)>,
}

/// Two histograms in turn: the older one is discarded.
pub(super) struct Window {
    hop: &'static str,
    arm: Option<u8>,
    now: Histogram,
    before: Histogram,
    turn_ns: u64,
}

impl Window {
    pub(super) fn new(hop: &'static str, arm: Option<usize>) -> Self {
        Self {
            hop,
            arm: arm.and_then(|arm| u8::try_from(arm).ok()),
            now: Histogram::new(),
            before: Histogram::new(),
            turn_ns: 0,
        }
    }

    /// Adds one hop between two times of the same clock (ns).
    pub(super) fn record(&mut self, from_ns: u64, to_ns: u64) {
        self.now.record(to_ns.saturating_sub(from_ns));
    }

    /// Summary of the window at `now_ns`.
    pub(super) fn report(&mut self, now_ns: u64) -> HopLatency {
        // Swapped, not cleared: figures stay those of at least five seconds.
        if now_ns >= self.turn_ns {
            self.turn_ns = now_ns + HALF_NS;
            std::mem::swap(&mut self.now, &mut self.before);
            self.now.clear();
        }
        let mut all = self.before.clone();
        all.merge(&self.now);
        let us = |ns: u64| ns as f64 * 1.0e-3;
        HopLatency {
            hop: self.hop,
            arm: self.arm,
            n: all.count(),
            p50_us: us(all.percentile(50.0)),
            p99_us: us(all.percentile(99.0)),
            p999_us: us(all.percentile(99.9)),
            max_us: us(all.max()),
            buckets: buckets(&all),
        }
    }
}

fn buckets(all: &Histogram) -> Vec<(u64, u64)> {
    let mut counts = [0; EDGES_US.len()];
    for (longest_ns, of_bucket) in all.buckets() {
        // A latency beyond the last edge counts there.
        let place = EDGES_US.partition_point(|edge| *edge < longest_ns / 1000);
        if let Some(count) = counts.get_mut(place.min(EDGES_US.len() - 1)) {
            *count += of_bucket;
        }
    }
    let filled = EDGES_US.into_iter().zip(counts);
    filled.filter(|(_, count)| *count > 0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_older_than_the_window_is_forgotten() {
        let mut window = Window::new("state to command", Some(1));
        window.report(0);
        window.record(1_000_000, 1_200_000);
        let hop = window.report(1);
        assert_eq!((hop.n, hop.arm), (1, Some(1)));
        assert!((hop.max_us - 200.0).abs() < 2.0, "{hop:?}");
        assert_eq!(hop.buckets.iter().map(|(_, count)| count).sum::<u64>(), 1);
        assert_eq!(window.report(HALF_NS).n, 1);
        assert_eq!(window.report(2 * HALF_NS + 1).n, 0);
    }
}
