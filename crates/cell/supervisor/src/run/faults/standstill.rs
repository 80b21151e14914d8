//! Whether lockstep waits for an answer that does not come.

/// How long lockstep may wait for an answer (ns): longer than any restart takes.
const STANDSTILL_NS: u64 = 20_000_000_000;

/// Since when the same tick is waited with.
#[derive(Debug, Default)]
pub(crate) struct Standstill {
    tick: u64,
    since_ns: Option<u64>,
}

impl Standstill {
    /// Takes note of the present tick; whether it has been waited with for too
    /// long.
    pub(crate) fn lasts(&mut self, tick: u64, waits: bool, now_ns: u64) -> bool {
        if tick != self.tick || !waits {
            self.tick = tick;
            self.since_ns = None;
        }
        let since_ns = *self.since_ns.get_or_insert(now_ns);
        waits && now_ns.saturating_sub(since_ns) > STANDSTILL_NS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_same_tick_for_a_long_time_is_a_standstill() {
        let mut standstill = Standstill::default();
        assert!(!standstill.lasts(5, true, 0));
        assert!(!standstill.lasts(5, true, STANDSTILL_NS));
        assert!(standstill.lasts(5, true, STANDSTILL_NS + 1));
        assert!(!standstill.lasts(6, true, STANDSTILL_NS + 2));
        assert!(!standstill.lasts(6, false, 3 * STANDSTILL_NS));
        assert!(!standstill.lasts(6, true, 3 * STANDSTILL_NS + 1));
    }
}
