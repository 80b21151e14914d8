//! Rate limit of the messages of one client.

/// Messages a second, and in one burst.
// Six times what a drag sends, and it sends at most 30 requests a second.
const PER_SECOND: f64 = 200.0;

/// Counts the messages of one client.
#[derive(Clone, Copy, Debug)]
pub struct RateLimit {
    left: f64,
    last_s: f64,
}

impl RateLimit {
    /// A client before its first message.
    pub fn new(now_s: f64) -> Self {
        Self {
            left: PER_SECOND,
            last_s: now_s,
        }
    }

    /// Counts a message at `now_s`; false when it is one too many.
    pub fn allows(&mut self, now_s: f64) -> bool {
        // A clock that goes back must not give credit.
        let passed_s = (now_s - self.last_s).max(0.0);
        self.last_s = now_s;
        self.left = (self.left + passed_s * PER_SECOND).min(PER_SECOND) - 1.0;
        // Counted even when refused: a page that floods stays refused until it pauses.
        self.left >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::RateLimit;

    #[test]
    fn two_hundred_a_second_pass_for_ever_and_more_do_not() {
        let mut limit = RateLimit::new(0.0);
        assert!((0..2000).all(|n| limit.allows(f64::from(n) / 200.0)));
        let mut limit = RateLimit::new(0.0);
        let passed = (0..1000)
            .take_while(|n| limit.allows(f64::from(*n) / 400.0))
            .count();
        assert!((390..=410).contains(&passed), "{passed}");
    }
}
