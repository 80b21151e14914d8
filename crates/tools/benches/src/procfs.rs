//! Figures of the kernel about a process, from `/proc`.

use std::fs;

/// Bytes of a kibibyte, the unit of `/proc/PID/smaps_rollup`.
const KIB: u64 = 1024;

/// Time of this thread on a processor (ns); `None` if the kernel does not count it.
pub(crate) fn own_thread_ns() -> Option<u64> {
    on_processor(&fs::read_to_string("/proc/thread-self/schedstat").ok()?)
}

/// Time on a processor (ns) in `/proc/PID/task/TID/schedstat`: other files have it in
/// hundredths of a second only.
pub(crate) fn on_processor(schedstat: &str) -> Option<u64> {
    schedstat.split_whitespace().next()?.parse().ok()
}

/// Memory of process `pid` (bytes): its share of each page, or all of its pages where the
/// kernel gives no shares. `None` if it has ended.
pub(crate) fn memory(pid: u32) -> Option<u64> {
    let file = |name: &str| fs::read_to_string(format!("/proc/{pid}/{name}")).ok();
    // Shares, as the processes of a cell have most of their program in common.
    let share = file("smaps_rollup").and_then(|text| field(&text, "Pss:"));
    // The resident size counts shared pages in each process, so it is only the fallback.
    share.or_else(|| field(&file("status")?, "VmRSS:"))
}

/// Memory of this process that is in use (bytes).
pub(crate) fn own_resident() -> Option<u64> {
    field(&fs::read_to_string("/proc/self/status").ok()?, "VmRSS:")
}

/// The line `name` (bytes).
fn field(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let count: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(count * KIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_number_is_the_time_on_a_processor() {
        assert_eq!(
            on_processor("1601507001 46256494 5928\n"),
            Some(1_601_507_001)
        );
        assert_eq!(on_processor("nonsense"), None);
    }

    #[test]
    fn memory_is_the_line_of_that_name() {
        let text = "Rss:    900 kB\nPss:    700 kB\nPss_Anon: 3 kB\n";
        assert_eq!(field(text, "Pss:"), Some(700 * 1024));
        assert_eq!(field(text, "Swap:"), None);
        assert_eq!(field("Pss: many\n", "Pss:"), None);
    }

    #[test]
    fn a_process_without_an_entry_has_no_memory() {
        assert!(memory(std::process::id()).is_some_and(|bytes| bytes > 0));
        assert_eq!(memory(u32::MAX), None);
    }
}
