//! Time without a task after kill -9.

use crate::report::{Row, Samples};
use cell_rt::process::{SIGKILL, kill};

/// Kills.
// Enough for a median; each costs the spacing below.
const KILLS: usize = 10;
/// Interval of the kills (ns): shorter ones would be a crash loop, and the supervisor would
/// give up the task.
const SPACING_NS: u64 = 2_500_000_000;

/// State of the task at one moment.
pub(super) struct Observation {
    /// Pid and generation of a running task.
    pub(super) task: Option<(u32, u32)>,
    /// Generation of the newest decision, and its publication time (ns).
    pub(super) decision: (u32, u64),
}

/// Kills the task repeatedly, each time after it has decided for a while.
#[derive(Default)]
pub(super) struct Kills {
    waits: Samples,
    /// Time (ns) of the last kill and the generation killed.
    killed: Option<(u64, u32)>,
    next_ns: u64,
}

impl Kills {
    /// One step at `now_ns`; true when all is measured. `strike` kills a pid; it returns false
    /// if the process has ended.
    pub(super) fn update(
        &mut self,
        now_ns: u64,
        seen: &Observation,
        strike: impl FnOnce(u32) -> bool,
    ) -> bool {
        let (decides, sent_ns) = seen.decision;
        match (self.killed, seen.task) {
            // A later generation: the killed one may have
            // decisions that are still being delivered.
            (Some((killed_ns, old)), _) if decides > old => {
                self.waits.record(sent_ns.saturating_sub(killed_ns));
                self.killed = None;
                self.next_ns = now_ns + SPACING_NS;
            }
            // Only a task that decides: a kill during its start would measure two starts.
            (None, Some((pid, generation))) if generation == decides && now_ns >= self.next_ns => {
                self.killed = strike(pid).then_some((now_ns, generation));
            }
            _ => {}
        }
        self.waits.count() >= KILLS
    }

    /// The durations so far.
    pub(super) fn waits(&self) -> &Samples {
        &self.waits
    }

    pub(super) fn into_row(self) -> Row {
        self.waits
            .into_row("task killed to its next decision".to_owned())
    }
}

/// Kills process `pid`; false if it has ended.
pub(super) fn strike(pid: u32) -> bool {
    kill(pid, SIGKILL).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn observe(task: Option<(u32, u32)>, decision: (u32, u64)) -> Observation {
        Observation { task, decision }
    }

    #[test]
    fn a_wait_lasts_until_the_next_task_decides_and_kills_are_far_apart() {
        let mut kills = Kills::default();
        let mut struck = Vec::new();
        let mut update = |now_ns, seen: Observation| {
            kills.update(now_ns, &seen, |pid| {
                struck.push((pid, now_ns));
                true
            })
        };
        update(5 * MS, observe(Some((40, 2)), (1, 4 * MS)));
        update(10 * MS, observe(Some((40, 2)), (2, 9 * MS)));
        update(15 * MS, observe(None, (2, 9 * MS)));
        update(30 * MS, observe(Some((41, 3)), (2, 9 * MS)));
        update(35 * MS, observe(Some((41, 3)), (3, 32 * MS)));
        update(40 * MS, observe(Some((41, 3)), (3, 39 * MS)));
        let later = 35 * MS + SPACING_NS;
        update(later, observe(Some((41, 3)), (3, later)));
        assert_eq!(struck, [(40, 10 * MS), (41, later)]);
        let row = kills.into_row();
        assert_eq!((row.n, row.p50, row.max), (1, 22_000.0, 22_000.0));
    }

    #[test]
    fn a_task_that_was_gone_already_is_no_kill() {
        let mut kills = Kills::default();
        kills.update(MS, &observe(Some((40, 1)), (1, MS)), |_| false);
        kills.update(2 * MS, &observe(Some((41, 2)), (2, 2 * MS)), |_| true);
        assert_eq!(kills.into_row().n, 0);
    }
}
