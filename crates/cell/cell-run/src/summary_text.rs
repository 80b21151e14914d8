//! The summary of a run in one line, for people.

use std::fmt::{Display, Formatter, Result};

use crate::summary::{RunOutcome, RunSummary};

impl Display for RunSummary {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let what = match self.outcome {
            RunOutcome::Done => "done",
            RunOutcome::Failed => "failed",
            RunOutcome::Timeout => "out of time",
            RunOutcome::Stopped => "stopped",
        };
        f.write_str(what)?;
        if let Some(reason) = &self.reason {
            write!(f, " ({reason})")?;
        }
        // The words of the reason are not repeated for a task without a separate sentence.
        let words = self.reason.as_ref().map(|reason| reason.replace('_', " "));
        if let Some(message) = self.message.as_ref().filter(|_| self.message != words) {
            write!(f, ": {message};")?;
        }
        let (simulated_s, wall_s) = (self.sim_time_s, self.wall_time_s);
        write!(f, " after {simulated_s:.2} s simulated in {wall_s:.2} s: ")?;
        if !self.placed.is_empty() {
            write!(f, "placed {}; ", self.placed.join(" "))?;
        }
        f.write_str(&recoveries(self))?;
        let (violations, hash) = (self.limit_violations, &self.state_hash);
        write!(f, "; {violations} limit violations")?;
        let contacts = [
            (
                self.obstacle_contacts,
                "contact with an obstacle",
                "contacts with obstacles",
            ),
            (
                self.self_contacts,
                "contact of an arm with itself",
                "contacts of arms with themselves",
            ),
        ];
        for (count, one, more) in contacts {
            let count = u32::try_from(count).unwrap_or(u32::MAX);
            if let Some(contacts) = many(count, one, more) {
                write!(f, "; {contacts}")?;
            }
        }
        write!(f, "; state {hash}")?;
        if let Some(lines) = many(self.script_left, "line", "lines") {
            let were = if self.script_left == 1 { "was" } else { "were" };
            write!(f, "; {lines} of the script {were} not reached")?;
        }
        self.faults
            .iter()
            .try_for_each(|fault| write!(f, "; fault of {fault}"))
    }
}

/// The disturbances from which the run recovered.
fn recoveries(summary: &RunSummary) -> String {
    let named = [
        many(summary.drops, "drop", "drops"),
        many(summary.resyncs, "resync", "resyncs"),
        many(summary.aborts, "abort", "aborts"),
    ];
    let mut counts: Vec<String> = named.into_iter().flatten().collect();
    let (one, more) = if counts.is_empty() {
        ("disturbance", "disturbances")
    } else {
        ("other disturbance", "other disturbances")
    };
    counts.extend(many(summary.recoveries, one, more));
    counts.extend(restarts(summary));
    match (counts.is_empty(), summary.outcome) {
        (true, _) => "nothing had to be recovered".to_owned(),
        (false, RunOutcome::Done) => format!("recovered from {}", counts.join(", ")),
        (false, _) => counts.join(", "),
    }
}

/// Restarts of each process. The summary of a run in one process has those of the task only.
fn restarts(summary: &RunSummary) -> Vec<String> {
    let of = |(process, count): (&str, u32)| {
        let (one, more) = (format!("{process} restart"), format!("{process} restarts"));
        many(count, &one, &more)
    };
    let all = summary.restarts.iter().map(|(name, n)| (name.as_str(), *n));
    let task = (!summary.restarts.contains_key("task")).then_some(("task", summary.task_restarts));
    all.chain(task).filter_map(of).collect()
}

/// A count with its word; `None` for 0.
fn many(count: u32, one: &str, more: &str) -> Option<String> {
    match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        _ => Some(format!("{count} {more}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::RunFacts;
    use ipc_types::{Decision, Wire, WorldState};

    #[test]
    fn lines_of_a_script_that_never_came_are_said() {
        let facts = RunFacts {
            demo: "reach",
            policy: "follow",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let mut state = WorldState::zeroed();
        let said =
            |state: &WorldState| RunSummary::new(&facts, state, &Decision::zeroed()).to_string();
        assert!(!said(&state).contains("script"));
        state.script_left = 2;
        assert!(said(&state).contains("; 2 lines of the script were not reached"));
    }

    #[test]
    fn a_fault_of_a_process_is_in_the_line() {
        let facts = RunFacts {
            demo: "reach",
            policy: "follow",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let (state, decision) = (WorldState::zeroed(), Decision::zeroed());
        let mut summary = RunSummary::new(&facts, &state, &decision);
        assert!(!summary.to_string().contains("fault"));
        summary.faults = vec!["physics: its state is not kept".to_owned()];
        let text = summary.to_string();
        assert!(
            text.ends_with("; fault of physics: its state is not kept"),
            "{text}"
        );
    }

    #[test]
    fn what_was_recovered_from_is_counted_and_does_not_read_as_a_failure() {
        let facts = RunFacts {
            demo: "ur10-fill-bin",
            policy: "matrix",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 1,
            missed_cycles: 0,
        };
        let mut decision = Decision::zeroed();
        let said = |decision: &Decision| {
            let mut summary = RunSummary::new(&facts, &WorldState::zeroed(), decision);
            summary.outcome = RunOutcome::Done;
            summary.to_string()
        };
        assert!(said(&decision).contains(": recovered from 1 task restart; "));
        (decision.drops, decision.recoveries) = (1, 2);
        let text = said(&decision);
        assert!(
            text.contains(": recovered from 1 drop, 2 other disturbances, 1 task restart; "),
            "{text}"
        );
        assert!(!text.contains("nothing"), "{text}");
        (decision.drops, decision.recoveries) = (0, 1);
        let text = said(&decision);
        assert!(
            text.contains(": recovered from 1 disturbance, 1 task restart; "),
            "{text}"
        );
    }

    #[test]
    fn a_restart_of_any_process_is_counted_and_not_called_nothing() {
        let facts = RunFacts {
            demo: "reach",
            policy: "follow",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let mut summary = RunSummary::new(&facts, &WorldState::zeroed(), &Decision::zeroed());
        summary.outcome = RunOutcome::Done;
        assert!(summary.to_string().contains("nothing had to be recovered"));
        summary.restarts = [("physics".to_owned(), 1), ("monitor".to_owned(), 2)].into();
        let text = summary.to_string();
        assert!(
            text.contains(": recovered from 2 monitor restarts, 1 physics restart; "),
            "{text}"
        );
        summary.outcome = RunOutcome::Failed;
        let text = summary.to_string();
        assert!(!text.contains("nothing had to be"), "{text}");
    }
}
