//! The lines that `run` prints while a cell runs: when it waits, and when its task is done.

use ipc_types::Decision;
use ipc_types::decision::Outcome;
use supervisor::run::LiveCell;

/// Follows the outcome of the task.
#[derive(Debug, Default)]
pub(super) struct Narrator {
    last: Option<Outcome>,
}

impl Narrator {
    /// The line about what changed, if something did.
    pub(super) fn look(&mut self, live: &LiveCell) -> Option<String> {
        let decision = live.watch().decision()?;
        let outcome = Outcome::from_code(decision.outcome)?;
        let before = self.last.replace(outcome);
        if before == Some(outcome) {
            return None;
        }
        let spec = live.spec();
        let cell = super::banner::cell_option(spec);
        line(before, outcome, decision, &live.names(decision), &cell)
    }

    /// Whether the task has ended.
    pub(super) fn is_over(&self) -> bool {
        matches!(self.last, Some(Outcome::Done | Outcome::Failed))
    }
}

/// `cell` is ` --cell NAME`, or empty.
fn line(
    before: Option<Outcome>,
    outcome: Outcome,
    decision: &Decision,
    placed: &[String],
    cell: &str,
) -> Option<String> {
    let time_s = decision.header.sim_time_ns as f64 * 1.0e-9;
    let placed = match placed {
        [] => String::new(),
        placed => format!(": placed {}", placed.join(" ")),
    };
    let reason = match decision.reason.as_str() {
        "" => String::new(),
        reason => format!(" ({reason})"),
    };
    let again = format!("`robocell reset{cell}` plays it again");
    match outcome {
        Outcome::Idle => Some(format!("waiting for: `robocell task start{cell}`")),
        Outcome::Done => Some(format!("done{reason} at {time_s:.2} s{placed}; {again}")),
        Outcome::Failed => Some(format!("failed{reason} at {time_s:.2} s{placed}; {again}")),
        Outcome::Paused => Some(format!(
            "task paused at {time_s:.2} s; waiting for: `robocell task resume{cell}`"
        )),
        Outcome::Running => before.map(|_| format!("task running at {time_s:.2} s")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Text, Wire};

    #[test]
    fn a_line_says_what_happened_when_and_what_to_do() {
        let mut decision = Decision::zeroed();
        decision.header.sim_time_ns = 42_100_000_000;
        let said = |outcome, decision: &Decision| {
            line(
                None,
                outcome,
                decision,
                &["red_cube".to_owned()],
                " --cell b",
            )
        };
        assert_eq!(
            said(Outcome::Done, &decision).unwrap(),
            "done at 42.10 s: placed red_cube; `robocell reset --cell b` plays it again"
        );
        decision.reason = Text::new("cube_out_of_reach");
        let failed = said(Outcome::Failed, &decision).unwrap();
        assert!(failed.starts_with("failed (cube_out_of_reach) at 42.10 s"));
        let idle = said(Outcome::Idle, &decision).unwrap();
        assert_eq!(idle, "waiting for: `robocell task start --cell b`");
        assert_eq!(
            said(Outcome::Running, &decision),
            None,
            "the first one is no news"
        );
    }
}
