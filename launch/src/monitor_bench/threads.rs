//! Processor time of a process, by the names of its threads.

use std::collections::BTreeMap;
use std::fs;

/// Clock ticks a second in `/proc`: always this on Linux.
const TICKS: f64 = 100.0;

/// Ticks used so far, by thread name.
pub(crate) struct Usage(BTreeMap<String, u64>);

impl Usage {
    /// Of process `pid`; empty when it is gone.
    pub(crate) fn of(pid: u32) -> Self {
        let mut by_name = BTreeMap::new();
        let tasks = fs::read_dir(format!("/proc/{pid}/task"));
        for task in tasks.into_iter().flatten().flatten() {
            let stat = fs::read_to_string(task.path().join("stat")).unwrap_or_default();
            if let Some((name, ticks)) = parse(&stat) {
                *by_name.entry(name).or_default() += ticks;
            }
        }
        Self(by_name)
    }

    /// Percent of a core since `before`, `seconds` ago: of all threads but the
    /// recorder, and of the recorder.
    pub(crate) fn since(&self, before: &Self, seconds: f64) -> Vec<(String, f64)> {
        let used = |is_wanted: &dyn Fn(&str) -> bool| -> f64 {
            let wanted = self.0.iter().filter(|(name, _)| is_wanted(name));
            let ticks = wanted.map(|(name, ticks)| {
                ticks.saturating_sub(before.0.get(name).copied().unwrap_or(0))
            });
            100.0 * ticks.sum::<u64>() as f64 / TICKS / seconds
        };
        vec![
            (
                "monitor with one viewer".to_owned(),
                used(&|n| n != "recorder"),
            ),
            ("recorder".to_owned(), used(&|n| n == "recorder")),
        ]
    }
}

/// Name and used ticks (user and system) in a line of `/proc/PID/task/TID/stat`.
fn parse(stat: &str) -> Option<(String, u64)> {
    // The name stands in brackets and may hold any character.
    let (head, tail) = stat.rsplit_once(')')?;
    let (_, name) = head.split_once('(')?;
    let mut fields = tail.split_whitespace().skip(11);
    let user: u64 = fields.next()?.parse().ok()?;
    let system: u64 = fields.next()?.parse().ok()?;
    Some((name.to_owned(), user + system))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_may_have_any_name() {
        let stat = "12 (a) b(c) S 1 12 12 0 -1 4 0 0 0 0 70 30 0 0 20 0 3";
        assert_eq!(parse(stat), Some(("a) b(c".to_owned(), 100)));
        assert_eq!(parse("nonsense"), None);
    }

    #[test]
    fn percent_is_of_one_core() {
        let usage = |r, m| Usage(BTreeMap::from([("recorder".into(), r), ("main".into(), m)]));
        let costs = usage(20, 300).since(&usage(10, 100), 10.0);
        assert_eq!((costs[0].1, costs[1].1), (20.0, 1.0));
    }
}
