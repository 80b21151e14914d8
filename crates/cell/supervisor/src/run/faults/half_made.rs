//! When half-made segments of the bus are looked for.

use cell_bus::RunSite;

/// A process that gives no sign of life for this long may wait for one (ns).
const SUSPICIOUS_NS: u64 = 30_000_000;
/// While processes are silent, the time between two looks (ns).
const PERIOD_NS: u64 = 50_000_000;

/// Removes what a process left half-made when it was killed, before its successor
/// starts, and for those that already wait for it.
#[derive(Debug)]
pub(crate) struct HalfMadeSweep {
    site: RunSite,
    next_ns: u64,
    /// One was in use at the last look, perhaps by one that waits for it.
    again: bool,
}

impl HalfMadeSweep {
    pub(crate) fn new(site: RunSite) -> Self {
        Self {
            site,
            next_ns: 0,
            again: false,
        }
    }

    /// Looks, if a process `ended`, one has been silent for `silence_ns`, or the last
    /// look was not enough.
    pub(crate) fn turn(&mut self, now_ns: u64, ended: bool, silence_ns: u64) {
        let suspicious = silence_ns >= SUSPICIOUS_NS && now_ns >= self.next_ns;
        if !(ended || suspicious || self.again) {
            return;
        }
        self.next_ns = now_ns + PERIOD_NS;
        // What cannot be removed now is tried again while a process is silent.
        let found = cell_bus::remove_half_made(&self.site).unwrap_or_default();
        self.again = found.in_use > 0;
    }
}
