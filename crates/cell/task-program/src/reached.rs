//! Whether any episode reached its policy server.

use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::runs::policy_server::{UNREACHABLE, is_address};
use cell_run::summary::RunSummary;
use evaluation::EvaluationError;
use evaluation::report;

use crate::exit::CONFIGURATION;
use crate::rows::{Order, Written};

/// Episodes, and those that did not reach their server.
#[derive(Default)]
pub(crate) struct Reached {
    episodes: AtomicU64,
    unreached: AtomicU64,
}

impl Reached {
    /// Counts an episode; `Err` is one that did not end.
    pub(crate) fn count(&self, result: &Result<RunSummary, String>) {
        let reason = result.as_ref().ok().and_then(|run| run.reason.as_deref());
        self.episodes.fetch_add(1, Ordering::Relaxed);
        self.unreached
            .fetch_add(u64::from(reason == Some(UNREACHABLE)), Ordering::Relaxed);
    }

    /// The exit code of an evaluation of `policy`. Without a server nothing was evaluated, so a
    /// script must not take the counts for a result.
    pub(crate) fn code(&self, policy: &str) -> ExitCode {
        let counts = [&self.episodes, &self.unreached];
        let [episodes, unreached] = counts.map(|count| count.load(Ordering::Relaxed));
        if episodes == 0 || unreached < episodes {
            return ExitCode::SUCCESS;
        }
        cell_worker::warn(format_args!(
            "no episode reached the policy server {policy}; start it, or correct --policy"
        ));
        ExitCode::from(CONFIGURATION)
    }
}

/// As [`Reached::code`], of the rows in a complete file, also of earlier commands.
pub(crate) fn code_of_rows(
    order: &Order<'_>,
    written: &Written,
) -> Result<ExitCode, EvaluationError> {
    let (out, policy) = (order.out, &order.spec.policy);
    // A shard may have no seeds, and thus no rows.
    if written.all == 0 || !is_address(policy) {
        return Ok(ExitCode::SUCCESS);
    }
    let rows = report::episodes(out)?;
    let mut failed = rows.failed.iter();
    if !rows.times_s.is_empty() || !failed.all(|row| row.name.as_deref() == Some(UNREACHABLE)) {
        return Ok(ExitCode::SUCCESS);
    }
    cell_worker::warn(format_args!(
        "{}: no episode reached the policy server {policy}; start it, or correct --policy, and remove \
         the file: rows that exist are not run again",
        out.display()
    ));
    Ok(ExitCode::from(CONFIGURATION))
}
