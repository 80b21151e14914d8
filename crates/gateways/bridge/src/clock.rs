//! The calendar clock, for other hosts.

use std::time::SystemTime;

/// Time since 1970 (ns). It can jump: only ages between hosts are computed from it.
#[allow(
    clippy::disallowed_methods,
    reason = "the monotonic clock means nothing on another host"
)]
pub fn wall_ns() -> i64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
    })
}

/// Calendar time of an event at `monotonic_ns` of this host.
pub fn wall_of(monotonic_ns: u64) -> i64 {
    // By its age: the two clocks have no fixed difference.
    let age = cell_rt::monotonic_ns().saturating_sub(monotonic_ns);
    wall_ns().saturating_sub(i64::try_from(age).unwrap_or(i64::MAX))
}
