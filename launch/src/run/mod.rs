//! `robocell run`: one cell from its first file to its last line.

mod arms;
mod banner;
mod first_page;
mod narrator;
pub(crate) mod one_process;
mod page_link;
pub(crate) mod plan;

use cell_run::spec::RecordSpec;
use cell_run::summary::{RunOutcome, RunSummary};
use supervisor::failure::{Code, Failure};
use supervisor::run::files::recording;
use supervisor::run::plan::Plan;
use supervisor::run::{End, LiveCell};

use crate::args::RunArgs;
use crate::{output, say, shell};
use first_page::PageWait;
use narrator::Narrator;
use page_link::PageLink;
pub use plan::resolve;

/// With `--loop`: from the end of the task to the next seed (ticks of 1 ms).
const LOOP_TICKS: u64 = 5000;

/// Runs a cell as the command line says.
pub(crate) fn run(args: &RunArgs) -> Result<(), Failure> {
    let mut plan = resolve(args)?;
    plan.spec.command = shell::typed();
    let mut waits_for_page = first_page::is_wanted(args, &plan.spec);
    plan.spec.paused |= waits_for_page;
    if args.one_process {
        return one_process::run(&plan, args.json);
    }
    let mut open = args.open;
    loop {
        let until_done = plan.spec.until_done;
        let record = plan.spec.record.clone();
        // Only at the first scene: for those that replace it the page is open already.
        let waits_for_page = std::mem::take(&mut waits_for_page);
        let link = PageLink::new(!args.json, std::mem::take(&mut open));
        let mut turns = Turns::new(args, &plan, waits_for_page, link);
        let about_arms = std::mem::take(&mut plan.about_arms);
        let live = LiveCell::start(plan)?;
        if !args.json {
            banner::announce(&live, &about_arms);
        }
        let end = live.stay(|live| turns.look(live));
        match end {
            End::Replaced(next) => plan = *next,
            // A script must not take a run that was stopped for one that is done.
            End::Stopped(_) if until_done => {
                report(&end, &record, args.json)?;
                return Err(Failure {
                    code: Code::TaskFailed,
                    message: "stopped before the task was done".to_owned(),
                });
            }
            end => return report(&end, &record, args.json),
        }
    }
}

/// What `run` does beside keeping the cell running.
struct Turns {
    greets: bool,
    talks: bool,
    loops: bool,
    link: PageLink,
    narrator: Narrator,
    page_wait: Option<PageWait>,
    /// With `--loop`: the tick the task ended at.
    over_tick: Option<u64>,
}

impl Turns {
    fn new(args: &RunArgs, plan: &Plan, waits_for_page: bool, link: PageLink) -> Self {
        let stays = plan.spec.time_limit_s.is_none();
        Self {
            greets: stays && !args.json,
            talks: stays && !args.json,
            loops: plan.loops,
            link,
            narrator: Narrator::default(),
            page_wait: waits_for_page.then(PageWait::default),
            over_tick: None,
        }
    }

    fn look(&mut self, live: &mut LiveCell) {
        // The words below are about the link above.
        let is_told = self.link.look(live);
        if !live.is_ready() || !is_told {
            return;
        }
        if std::mem::take(&mut self.greets) {
            banner::ready(live, self.page_wait.is_some());
        }
        if let Some(wait) = &mut self.page_wait {
            wait.look(live);
        }
        if let Some(line) = self.narrator.look(live).filter(|_| self.talks) {
            say::line(line);
        }
        if self.loops {
            self.begin_again(live);
        }
    }

    /// The next seed, some time after the task has ended.
    fn begin_again(&mut self, live: &mut LiveCell) {
        if !self.narrator.is_over() {
            // The operator has reset the task: the time is counted from its next end.
            self.over_tick = None;
            return;
        }
        let Some(tick) = live.watch().state().map(|state| state.header.tick) else {
            return;
        };
        let over_tick = *self.over_tick.get_or_insert(tick);
        if tick >= over_tick + LOOP_TICKS {
            // Refused while another scene is planned; then the next look tries again.
            self.loops = !live.play_next_seed();
        }
    }
}

/// The last words of a run, and its exit code.
fn report(end: &End, record: &RecordSpec, json: bool) -> Result<(), Failure> {
    if let End::Finished(summary) | End::Stopped(Some(summary)) = end {
        if json {
            output::print(summary)?;
        } else {
            say::line(summary);
            let lines = banner::recording(record, summary);
            lines.iter().for_each(say::line);
        }
    }
    match end {
        End::Finished(summary) => {
            code_of(summary)?;
            if recording::failed(record, summary) {
                // It is said already.
                return Err(Failure::silent(Code::Configuration));
            }
            Ok(())
        }
        End::Stopped(_) | End::Replaced(_) => Ok(()),
        End::GaveUp(failure) => Err(failure.clone()),
    }
}

/// The exit code a summary asks for.
pub(crate) fn code_of(summary: &RunSummary) -> Result<(), Failure> {
    match summary.outcome {
        RunOutcome::Done => Ok(()),
        RunOutcome::Failed | RunOutcome::Timeout | RunOutcome::Stopped => {
            Err(Failure::silent(Code::TaskFailed))
        }
    }
}
