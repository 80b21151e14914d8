//! The monotonic clock: it neither jumps nor knows the time of day.

/// Time of a loop: [`Monotonic`] in a process, virtual time in a model of the cell.
// A type parameter of the loops, not an object: a reading in a 1 kHz cycle stays a direct call.
pub trait Clock {
    /// Nanoseconds since an arbitrary start; never earlier than the reading before.
    fn now_ns(&self) -> u64;
}

/// The clock of the machine, [`monotonic_ns`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Monotonic;

impl Clock for Monotonic {
    #[inline]
    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }
}

/// `CLOCK_MONOTONIC` in nanoseconds. The same value in every process of the
/// machine.
#[inline]
pub fn monotonic_ns() -> u64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the pointer is to a live timespec; the clock always exists, so
    // the call cannot fail.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut time) };
    time.tv_sec.unsigned_abs() * 1_000_000_000 + time.tv_nsec.unsigned_abs()
}

/// Sleeps until [`monotonic_ns`] reaches `deadline_ns`; returns at once when it
/// has. Signals do not shorten the sleep.
pub fn sleep_until(deadline_ns: u64) {
    let time = libc::timespec {
        tv_sec: i64::try_from(deadline_ns / 1_000_000_000).unwrap_or(i64::MAX),
        tv_nsec: i64::try_from(deadline_ns % 1_000_000_000).unwrap_or(0),
    };
    loop {
        // SAFETY: the pointer is to a live timespec; no remainder is asked for,
        // as the deadline is absolute.
        let result = unsafe {
            libc::clock_nanosleep(
                libc::CLOCK_MONOTONIC,
                libc::TIMER_ABSTIME,
                &raw const time,
                core::ptr::null_mut(),
            )
        };
        if result != libc::EINTR {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sleep_never_ends_early() {
        let deadline = monotonic_ns() + 2_000_000;
        sleep_until(deadline);
        assert!(monotonic_ns() >= deadline);
    }

    #[test]
    fn a_deadline_in_the_past_returns() {
        sleep_until(0);
    }
}
