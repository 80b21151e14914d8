//! Processor time of a process, by the names of its threads.

use std::collections::BTreeMap;
use std::fs;

use crate::procfs::on_processor;

/// Time used so far (ns), by thread name.
pub(crate) struct Usage(BTreeMap<String, u64>);

impl Usage {
    /// Of process `pid`; empty if it has ended.
    pub(crate) fn of(pid: u32) -> Self {
        let mut by_name = BTreeMap::new();
        let tasks = fs::read_dir(format!("/proc/{pid}/task"));
        for task in tasks.into_iter().flatten().flatten() {
            let file = |name: &str| fs::read_to_string(task.path().join(name));
            let name = file("comm").unwrap_or_default().trim_end().to_owned();
            if let Some(used_ns) = file("schedstat").ok().as_deref().and_then(on_processor) {
                // Threads of one name are one row: the runtime may have several.
                *by_name.entry(name).or_default() += used_ns;
            }
        }
        Self(by_name)
    }

    /// Percent of a core since `before`, `seconds` ago: of all threads except the recorder, and
    /// of the recorder.
    pub(crate) fn since(&self, before: &Self, seconds: f64) -> [f64; 2] {
        let (mut others_ns, mut recorder_ns) = (0, 0);
        for (name, used_ns) in &self.0 {
            let used_ns = used_ns.saturating_sub(before.0.get(name).copied().unwrap_or(0));
            if name == "recorder" {
                recorder_ns += used_ns;
            } else {
                others_ns += used_ns;
            }
        }
        [others_ns, recorder_ns].map(|used_ns| used_ns as f64 * 1.0e-7 / seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_is_of_one_core_and_the_recorder_is_told_apart() {
        let usage = |page: u64, recorder: u64, main: u64| {
            let names = ["page", "recorder", "main"].map(str::to_owned);
            let used = [page, recorder, main].map(|ms| ms * 1_000_000);
            Usage(names.into_iter().zip(used).collect())
        };
        let costs = usage(500, 200, 3000).since(&usage(0, 100, 1500), 10.0);
        assert_eq!(costs, [20.0, 1.0]);
    }
}
