//! What became of the jobs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use cell_run::summary::{RunOutcome, RunSummary};
use ipc_types::TICK_NS;
use schemars::JsonSchema;
use serde::Serialize;

use super::kills::{Kill, MOST_TICKS_LOST};

/// Percentiles of the time until a process was back (ms).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Recovery {
    pub(super) p50: f64,
    pub(super) p99: f64,
    pub(super) max: f64,
}

impl Recovery {
    pub(super) fn of(mut times_ms: Vec<f64>) -> Self {
        times_ms.sort_by(f64::total_cmp);
        let at = |share: usize| {
            let index = (times_ms.len() * share / 100).min(times_ms.len().saturating_sub(1));
            times_ms.get(index).copied().unwrap_or(0.0)
        };
        Self {
            p50: at(50),
            p99: at(99),
            max: at(100),
        }
    }
}

/// The result of `robocell chaos --json`; the keys are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Report {
    pub(super) demo: String,
    pub(super) seed: u64,
    /// Duration; null with `--kills`.
    pub(super) minutes: Option<f64>,
    /// How many of each kind were injected.
    pub(super) faults: BTreeMap<String, u32>,
    pub(super) recovery_ms: Recovery,
    pub(super) jobs_done: u32,
    pub(super) jobs_failed: u32,
    /// Parts fewer in their places than in the fullest job.
    pub(super) parts_lost: u32,
    pub(super) limit_violations: u64,
    /// Processes, segments and files that a job left behind.
    pub(super) leftovers: usize,
    /// Each kill of `--kills`; empty without.
    pub(super) kills: Vec<Kill>,
    /// Kills of `--kills` that were not done.
    pub(super) kills_missing: usize,
    #[serde(skip)]
    placed: Vec<usize>,
}

impl Report {
    pub(super) fn new(demo: &str, seed: u64) -> Self {
        Self {
            demo: demo.to_owned(),
            seed,
            minutes: None,
            faults: BTreeMap::new(),
            recovery_ms: Recovery::default(),
            jobs_done: 0,
            jobs_failed: 0,
            parts_lost: 0,
            limit_violations: 0,
            leftovers: 0,
            kills: Vec::new(),
            kills_missing: 0,
            placed: Vec::new(),
        }
    }

    /// A job that was not stopped has ended.
    pub(super) fn job(&mut self, summary: &RunSummary) {
        self.limit_violations += summary.limit_violations;
        if summary.outcome != RunOutcome::Done {
            self.jobs_failed += 1;
            return;
        }
        self.jobs_done += 1;
        self.placed.push(summary.placed.len());
        // Computed for all jobs again: a later job may be fuller than those before.
        let most = self.placed.iter().copied().max().unwrap_or(0);
        let lost: usize = self.placed.iter().map(|placed| most - placed).sum();
        self.parts_lost = u32::try_from(lost).unwrap_or(u32::MAX);
    }

    /// The kills of `--kills`, all of them.
    pub(super) fn kills(&mut self, kills: Vec<Kill>, missing: usize) {
        let count = u32::try_from(kills.len()).unwrap_or(u32::MAX);
        self.faults.insert("kill".to_owned(), count);
        self.recovery_ms = Recovery::of(kills.iter().filter_map(|kill| kill.back_ms).collect());
        (self.kills, self.kills_missing) = (kills, missing);
    }

    /// Whether a promise was broken.
    pub(super) fn is_bad(&self) -> bool {
        let is_lost = self.jobs_failed > 0 || self.parts_lost > 0 || self.leftovers > 0;
        is_lost || self.kills_missing > 0 || self.kills.iter().any(Kill::is_bad)
    }

    /// For people.
    pub(super) fn table(&self) -> String {
        let mut out = self.kill_table();
        let faults = self.faults.iter().map(|(kind, n)| format!("{kind} {n}"));
        let faults: Vec<_> = faults.collect();
        let recovery = &self.recovery_ms;
        let rows = [
            ("jobs finished", self.jobs_done.to_string()),
            ("jobs failed", self.jobs_failed.to_string()),
            ("faults", faults.join(", ")),
            (
                "recovery",
                format!(
                    "p50 {:.0} ms, p99 {:.0} ms, max {:.0} ms",
                    recovery.p50, recovery.p99, recovery.max
                ),
            ),
            ("parts lost", self.parts_lost.to_string()),
            ("limit violations", self.limit_violations.to_string()),
            ("leftovers", self.leftovers.to_string()),
        ];
        for (name, value) in rows {
            // Writing to a string cannot fail.
            let _written = writeln!(out, "{name:<18}{value}").is_ok();
        }
        if let Some(most) = self.kills.iter().filter_map(|kill| kill.ticks_lost).max() {
            let row = format!("{most} at most, {MOST_TICKS_LOST} are allowed");
            let _written = writeln!(out, "{:<18}{row}", "ticks lost").is_ok();
        }
        out
    }

    /// A line for each kill of `--kills`.
    fn kill_table(&self) -> String {
        let mut out = String::new();
        if self.kills.is_empty() {
            return out;
        }
        let heads = "kill   job  process              at s  ticks lost  back after ms";
        let _written = writeln!(out, "{heads}").is_ok();
        for (number, kill) in (1..).zip(&self.kills) {
            let at_s = (kill.tick * TICK_NS) as f64 * 1.0e-9;
            let lost = kill.ticks_lost.map_or("-".to_owned(), |n| n.to_string());
            let back = kill.back_ms.map(|ms| format!("{ms:.0}"));
            let back = back.unwrap_or_else(|| "never".to_owned());
            let mark = if kill.is_bad() { "  <- broken" } else { "" };
            let _written = writeln!(
                out,
                "{number:>4} {:>5}  {:<14} {at_s:>10.3} {lost:>11} {back:>14}{mark}",
                kill.job, kill.process
            )
            .is_ok();
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_run::summary::RunFacts;
    use ipc_types::decision::Outcome;
    use ipc_types::{Decision, Wire, WorldState};

    fn summary(outcome: Outcome, placed: u32) -> RunSummary {
        let objects: Vec<String> = (0..9).map(|n| format!("part_{n}")).collect();
        let facts = RunFacts {
            demo: "d",
            policy: "p",
            seed: 0,
            objects: &objects,
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let mut decision = Decision::zeroed();
        decision.outcome = outcome.code();
        decision.placed_count = placed;
        for index in 0..placed {
            decision.placed[index as usize] = index;
        }
        RunSummary::new(&facts, &WorldState::zeroed(), &decision)
    }

    #[test]
    fn a_part_is_lost_where_a_finished_job_has_fewer_than_the_others() {
        let mut report = Report::new("d", 1);
        report.job(&summary(Outcome::Done, 3));
        report.job(&summary(Outcome::Done, 4));
        report.job(&summary(Outcome::Failed, 0));
        report.job(&summary(Outcome::Done, 4));
        assert_eq!(
            (report.jobs_done, report.jobs_failed, report.parts_lost),
            (3, 1, 1)
        );
    }

    #[test]
    fn the_keys_are_the_published_ones() {
        let mut report = Report::new("franka-stack", 7);
        report.minutes = Some(0.5);
        report.faults.insert("kill".to_owned(), 2);
        report.recovery_ms = Recovery::of(vec![30.0, 10.0, 20.0]);
        assert_eq!(
            serde_json::to_string(&report).unwrap(),
            r#"{"demo":"franka-stack","seed":7,"minutes":0.5,"faults":{"kill":2},"recovery_ms":{"p50":20.0,"p99":30.0,"max":30.0},"jobs_done":0,"jobs_failed":0,"parts_lost":0,"limit_violations":0,"leftovers":0,"kills":[],"kills_missing":0}"#
        );
        assert!(report.table().contains("kill 2"));
    }

    #[test]
    fn a_kill_that_went_too_far_back_is_marked_and_makes_the_report_bad() {
        let kill = |ticks_lost| Kill {
            job: 2,
            seed: 7,
            process: "physics".to_owned(),
            tick: 10_240,
            ticks_lost: Some(ticks_lost),
            back_ms: Some(45.2),
        };
        let mut report = Report::new("franka-stack", 7);
        report.kills(vec![kill(1000)], 0);
        assert!(!report.is_bad());
        report.kills(vec![kill(1000), kill(91_200)], 0);
        assert!(report.is_bad());
        let table = report.table();
        assert!(table.contains("ticks lost        91200 at most"), "{table}");
        assert_eq!(table.matches("<- broken").count(), 1, "{table}");
        assert_eq!(
            serde_json::to_string(&report.kills[1]).unwrap(),
            r#"{"job":2,"seed":7,"process":"physics","tick":10240,"ticks_lost":91200,"back_ms":45.2}"#
        );
        // A kill that is missing proves nothing.
        report.kills(vec![kill(10)], 1);
        assert!(report.is_bad());
    }
}
