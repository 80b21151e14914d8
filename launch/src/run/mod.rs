//! `robocell run`: one cell from its first file to its last line.

mod banner;
mod bus_thread;
mod faults;
mod half_made;
mod incident;
mod live;
mod one_process;
mod phases;
pub(crate) mod plan;
pub(crate) mod preflight;
mod recording;
mod room;
mod standstill;
mod starvation;
mod watch;
mod wish;

use cell_model::runs::spec::RecordSpec;
use cell_model::runs::summary::{RunOutcome, RunSummary};

use crate::cli::RunArgs;
use crate::failure::{Code, Failure};
use crate::say;
pub use live::{End, LiveCell};
pub use plan::Plan;
pub use watch::Watch;

/// Runs a cell as the command line says.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let mut plan = Plan::resolve(args)?;
    if args.one_process {
        return one_process::run(&plan, args.json);
    }
    loop {
        let until_done = plan.spec.until_done;
        let mut greet = plan.stays && !args.json;
        let record = plan.spec.record.clone();
        let live = LiveCell::start(plan)?;
        if !args.json {
            live.announce();
        }
        let end = live.stay(|live| {
            if greet && live.is_ready() {
                greet = false;
                banner::ready(live);
            }
        });
        match end {
            End::Replaced(next) => plan = *next,
            End::Stopped if until_done => {
                return Err(Failure {
                    code: Code::TaskFailed,
                    message: "stopped before the task was done".to_owned(),
                });
            }
            end => return report(&end, &record, args.json),
        }
    }
}

/// The last words of a run, and its exit code.
fn report(end: &End, record: &RecordSpec, json: bool) -> Result<(), Failure> {
    match end {
        End::Finished(summary) => {
            if json {
                say::line(serde_json::to_string(summary).map_err(Failure::configuration)?);
            } else {
                say::line(summary);
            }
            code_of(summary)?;
            if recording::failed(record, summary) {
                // It is said already.
                return Err(Failure::silent(Code::Configuration));
            }
            Ok(())
        }
        End::Stopped | End::Replaced(_) => Ok(()),
        End::GaveUp(failure) => Err(failure.clone()),
    }
}

/// The exit code a summary asks for.
pub(crate) fn code_of(summary: &RunSummary) -> Result<(), Failure> {
    match summary.outcome {
        RunOutcome::Done => Ok(()),
        RunOutcome::Failed | RunOutcome::Timeout => Err(Failure::silent(Code::TaskFailed)),
    }
}
