//! The least disturbance that breaks a task, for `eval bisect`.

use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use cell_model::cells::axis::Axis;
use cell_model::cells::sweep::Bounds;
use cell_model::runs::summary::RunOutcome;
use cell_sim::{Program, SimError, episodes, eval};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Number;

use crate::output::{print_json, print_line};
use crate::progress::Progress;
use crate::reached::Reached;
use crate::warned::Warned;

/// What to search.
pub(crate) struct Search {
    /// The episodes that are run with each value.
    pub(crate) plan: eval::Plan,
    /// The number, with a value at which the task is done and one at which it is not.
    pub(crate) bounds: Bounds,
    /// Share of the episodes that must be done.
    pub(crate) least_done: f64,
    /// Values that are tried between the bounds.
    pub(crate) steps: u32,
}

/// What became of the episodes with one value.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Tried {
    /// The value.
    value: Number,
    /// Episodes that ended done.
    done: u64,
    /// All of them.
    episodes: u64,
    /// Whether enough of them were done.
    holds: bool,
    /// The least seed that did not end done.
    first_failed: Option<FirstFailed>,
}

/// An episode that did not end done.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
struct FirstFailed {
    seed: u64,
    reason: String,
    /// The reason, or the newest fault, in a sentence.
    message: Option<String>,
}

/// What was found; `eval bisect --json` prints it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Found {
    /// The key of the cell file.
    key: String,
    /// First and last seed.
    seeds: [u64; 2],
    /// Share of the episodes that must be done.
    least_done: f64,
    /// The largest value tried, below those that break the task, with which it holds; none
    /// where it breaks at the lower bound.
    holds: Option<Number>,
    /// The least value that breaks the task; none where it holds at the upper bound.
    breaks: Option<Number>,
    /// All values, in the order they were tried.
    tried: Vec<Tried>,
}

/// Searches, and prints the result.
pub(crate) fn run(program: &Program, search: &Search, json: bool) -> Result<ExitCode, SimError> {
    let (plan, key) = (&search.plan, &search.bounds.key);
    let axis = episodes::axis(program, &plan.spec, search.bounds.clone())?;
    let values = u64::from(search.steps) + 2;
    let reached = Reached::default();
    let progress = Progress::of_runs(values.saturating_mul(plan.episodes()));
    let mut found = Found {
        key: key.clone(),
        seeds: [*plan.seeds.start(), *plan.seeds.end()],
        least_done: search.least_done,
        holds: None,
        breaks: None,
        tried: Vec::new(),
    };
    // Both bounds first: between two that hold, or two that break, there is nothing to search.
    for end in axis.ends() {
        let tried = search.try_value(program, &axis, end, (&progress, &reached))?;
        progress.print(|| print_result(key, &tried, json));
        found.take(tried);
        // The lower bound breaks the task: values above it cannot be the least one that does.
        if found.breaks.is_some() {
            break;
        }
    }
    for _ in 0..search.steps {
        let between = found.holds.as_ref().zip(found.breaks.as_ref());
        // `None` where no number is left between the two, so whole numbers end early.
        let Some(middle) = between.and_then(|(low, high)| axis.middle(low, high)) else {
            break;
        };
        let tried = search.try_value(program, &axis, middle, (&progress, &reached))?;
        progress.print(|| print_result(key, &tried, json));
        found.take(tried);
    }
    // The progress line is removed before the result is printed over it.
    drop(progress);
    if json {
        print_json(&found);
    } else {
        print_line(format_args!("{}", found.verdict()));
    }
    Ok(reached.code(&plan.spec.policy))
}

impl Search {
    fn try_value(
        &self,
        program: &Program,
        axis: &Axis,
        value: Number,
        (progress, reached): (&Progress, &Reached),
    ) -> Result<Tried, SimError> {
        let (failed, warned) = (Mutex::new(Vec::new()), Warned::default());
        // Each value is tried with the same seeds: otherwise a lucky seed could look like a
        // tolerant task.
        let plan = self.plan.with(&axis.at(&value));
        let counts = eval::evaluate(program, &plan, |ended| {
            progress.run(|| {});
            reached.count(&ended.result);
            progress.print(|| warned.show(&ended.warnings));
            let (reason, message) = match &ended.result {
                Ok(summary) if summary.outcome == RunOutcome::Done => return,
                Ok(summary) => {
                    let outcome = || format!("{:?}", summary.outcome).to_lowercase();
                    let reason = summary.reason.clone().unwrap_or_else(outcome);
                    (reason, summary.message.clone())
                }
                Err(why) => (why.clone(), Some(why.clone())),
            };
            // Episodes run on several threads and end in any order; the least seed is reported,
            // so that the output does not depend on the number of jobs.
            let seed = ended.case.seed;
            let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
            failed.push(FirstFailed {
                seed,
                reason,
                message,
            });
        })?;
        let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Tried {
            value,
            done: counts.done,
            episodes: counts.runs,
            holds: counts.done as f64 >= self.least_done * counts.runs as f64,
            first_failed: failed.into_iter().min(),
        })
    }
}

impl Found {
    fn take(&mut self, tried: Tried) {
        // The newest value that holds, or breaks, is the nearer bound: values are tried between
        // the two.
        let end = if tried.holds {
            &mut self.holds
        } else {
            &mut self.breaks
        };
        *end = Some(tried.value.clone());
        self.tried.push(tried);
    }

    fn verdict(&self) -> String {
        let key = &self.key;
        match (&self.holds, &self.breaks) {
            (Some(holds), Some(breaks)) => {
                format!("{key} breaks the task between {holds} and {breaks}")
            }
            (None, Some(breaks)) => {
                format!("{key} breaks the task at {breaks}, the lower bound, already")
            }
            (Some(holds), None) => format!("the task holds up to {key}={holds}, the upper bound"),
            (None, None) => format!("no value of {key} was tried"),
        }
    }
}

/// Prints a line for each value, as soon as its result is known.
fn print_result(key: &str, tried: &Tried, json: bool) {
    if json {
        return;
    }
    let verdict = if tried.holds { "holds" } else { "breaks" };
    let failed = tried.first_failed.as_ref();
    let failed = failed.map(|first| {
        let why = first.message.as_ref().unwrap_or(&first.reason);
        format!(" (seed {}: {why})", first.seed)
    });
    print_line(format_args!(
        "{key}={}  {} of {} done  {verdict}{}",
        tried.value,
        tried.done,
        tried.episodes,
        failed.unwrap_or_default()
    ));
}

#[cfg(test)]
mod tests;
