//! `robocell chaos`: jobs back to back, and faults while they run.

mod fault;
mod kills;
mod report;

use cell_model::random::Random;
use cell_rt::clock::monotonic_ns;
use cell_rt::signal::stop_requested;
use cell_run::summary::RunOutcome;
use clap::Parser;
use ipc_types::topic::Process;
use ipc_types::world::FLAG_ENDING;
use supervisor::failure::{Code, Failure};
use supervisor::leftovers::Leftovers;
use supervisor::run::plan::Plan;
use supervisor::run::{End, LiveCell};

use crate::args::kinds::FaultKind;
use crate::args::{ChaosArgs, Cli, Command, ProcessName};
use crate::run;
use crate::{output, say};
use fault::{Begun, Faults, Struck, kill_one};
use kills::{Kills, Sight};
use report::Recovery;
pub(crate) use report::Report;

const SECOND_NS: u64 = 1_000_000_000;
/// A process that is not back after this is counted with it (ns).
const LONGEST_NS: u64 = 30 * SECOND_NS;

/// Does what the command line says.
pub(crate) fn chaos(args: &ChaosArgs) -> Result<(), Failure> {
    let mut report = Report::new(&args.demo, args.seed);
    let mut course = match args.kills {
        Some(count) => Course::Kills(Kills::new(count, args.seed)),
        None => Course::Faults(Box::new(Injector::new(args, &mut report))),
    };
    let mut job = 0;
    while !course.is_over() && !stop_requested() {
        let seed = args.seed.wrapping_add(job);
        let plan = plan(args, seed)?;
        job += 1;
        course.begin_job(job, seed);
        let ticks = play(args, plan, job, &mut course, &mut report)?;
        course.end_of_job(ticks);
    }
    let note = course.end(&mut report);
    if args.json {
        output::print(&report)?;
    } else {
        say::raw(report.table().as_bytes());
    }
    if let Some(note) = note {
        say::warn(note);
    }
    if report.is_bad() {
        return Err(Failure::silent(Code::TaskFailed));
    }
    Ok(())
}

/// One job; its length in ticks where it was done.
fn play(
    args: &ChaosArgs,
    plan: Plan,
    job: u64,
    course: &mut Course,
    report: &mut Report,
) -> Result<Option<u64>, Failure> {
    let dir = plan.dir.clone();
    let live = LiveCell::start(plan)?;
    let end = live.stay(|live| course.turn(live, args, report));
    // `stay` has ended all processes and removed their files: anything that is left is a leak.
    report.leftovers += Leftovers::find(&dir).count();
    let mut ticks = None;
    match end {
        End::Finished(summary) => {
            report.job(&summary);
            ticks = (summary.outcome == RunOutcome::Done).then_some(summary.ticks);
            if ticks.is_none() {
                let reason = summary.reason.as_deref().unwrap_or("out of time");
                say::warn(format_args!("job {job} failed: {reason}"));
            }
        }
        End::GaveUp(failure) => {
            report.jobs_failed += 1;
            say::warn(format_args!("job {job}: {failure}"));
        }
        // Stopped at the end of the series or by a person: neither finished nor failed.
        End::Stopped(_) | End::Replaced(_) => {}
    }
    if !args.json {
        say::line(format_args!(
            "job {job}: {} finished, {} failed, {} parts lost",
            report.jobs_done, report.jobs_failed, report.parts_lost
        ));
    }
    Ok(ticks)
}

/// The run of one job, as `robocell run` would have it.
fn plan(args: &ChaosArgs, seed: u64) -> Result<Plan, Failure> {
    let seed = seed.to_string();
    // Parsed from words: only the parser of `run` knows its defaults.
    let mut words = vec!["robocell", "run", &args.demo, "--headless", "--until-done"];
    words.extend(["--seed", &seed, "--cell", &args.cell]);
    if let Some(policy) = &args.policy {
        words.extend(["--policy", policy]);
    }
    let mut cli = Cli::try_parse_from(words).map_err(Failure::usage)?;
    match &mut cli.command {
        Command::Run(words) => {
            words.data = args.data.clone();
            words.scene.speed = args.speed;
            words.job.bins = args.bins;
            words.job.script.clone_from(&args.script);
            run::resolve(words)
        }
        _ => Err(Failure::usage("no run")),
    }
}

/// What happens to the jobs.
enum Course {
    /// Faults for a time.
    Faults(Box<Injector>),
    /// A number of kills.
    Kills(Kills),
}

impl Course {
    fn is_over(&self) -> bool {
        match self {
            Self::Faults(injector) => monotonic_ns() >= injector.end_ns,
            Self::Kills(kills) => kills.is_over(),
        }
    }

    fn begin_job(&mut self, job: u64, seed: u64) {
        match self {
            Self::Faults(_) => {}
            Self::Kills(kills) => kills.begin_job(job, seed),
        }
    }

    fn turn(&mut self, live: &mut LiveCell, args: &ChaosArgs, report: &mut Report) {
        match self {
            Self::Faults(injector) => injector.turn(live, report),
            Self::Kills(kills) => {
                let now_ns = monotonic_ns();
                let strike = |random: &mut Random| kill_one(live, args.process, random, now_ns);
                kills.turn(now_ns, &sight(live), strike, |process| {
                    works_since(live, process)
                });
            }
        }
    }

    fn end_of_job(&mut self, ticks: Option<u64>) {
        match self {
            Self::Faults(injector) => injector.end_of_job(),
            Self::Kills(kills) => kills.end_of_job(ticks),
        }
    }

    /// Completes the report; what else a person has to know.
    fn end(self, report: &mut Report) -> Option<String> {
        match self {
            Self::Faults(injector) => {
                report.recovery_ms = Recovery::of(injector.recoveries_ms);
                let kinds = injector.impossible.into_iter().map(word);
                let kinds = kinds.collect::<Vec<_>>().join(", ");
                (!kinds.is_empty()).then(|| format!("{kinds} could not be done here"))
            }
            Self::Kills(kills) => {
                let (missing, why) = (kills.missing(), kills.why_over(stop_requested()));
                report.kills(kills.into_done(), missing);
                let are = if missing == 1 { "kill is" } else { "kills are" };
                (missing > 0).then(|| format!("{missing} {are} missing: {why}"))
            }
        }
    }
}

/// State of a running cell.
fn sight(live: &LiveCell) -> Sight {
    let Some(state) = live.watch().state() else {
        return Sight::default();
    };
    Sight {
        can_be_hit: live.is_ready() && !state.has(FLAG_ENDING),
        tick: state.header.tick,
        generation: state.header.generation,
        resumed_tick: state.resumed_tick,
    }
}

fn word(kind: FaultKind) -> String {
    format!("{kind:?}").to_lowercase()
}

/// Injects faults while a cell runs.
struct Injector {
    kinds: Vec<FaultKind>,
    /// Mean time between two faults (ns).
    mean_ns: f64,
    end_ns: u64,
    random: Random,
    next_ns: u64,
    only: Option<ProcessName>,
    faults: Faults,
    struck: Vec<Struck>,
    recoveries_ms: Vec<f64>,
    impossible: Vec<FaultKind>,
}

impl Injector {
    fn new(args: &ChaosArgs, report: &mut Report) -> Self {
        report.minutes = Some(args.minutes);
        report.faults = args.faults.iter().map(|kind| (word(*kind), 0)).collect();
        Self {
            kinds: args.faults.clone(),
            mean_ns: 60.0e9 / args.rate,
            end_ns: monotonic_ns() + nanos(args.minutes * 60.0),
            random: Random::new(args.seed),
            next_ns: 0,
            only: args.process,
            faults: Faults::new(args.process),
            struck: Vec::new(),
            recoveries_ms: Vec::new(),
            impossible: Vec::new(),
        }
    }

    fn turn(&mut self, live: &mut LiveCell, report: &mut Report) {
        let now_ns = monotonic_ns();
        self.note_recoveries(live, now_ns);
        self.faults.turn(live, now_ns);
        if now_ns >= self.end_ns {
            live.stop();
            return;
        }
        if !live.is_ready() {
            return;
        }
        // The first pause starts when the cell works, however long its start took.
        if self.next_ns == 0 {
            self.next_ns = now_ns + self.pause_ns();
        }
        if now_ns < self.next_ns {
            return;
        }
        self.next_ns = now_ns + self.pause_ns();
        let choice = self.random.below(self.kinds.len());
        let Some(kind) = self.kinds.get(choice).copied() else {
            return;
        };
        match self.faults.begin(kind, live, &mut self.random, now_ns) {
            Some(begun) => {
                *report.faults.entry(word(kind)).or_default() += 1;
                if let Begun::Gone(struck) = begun {
                    self.struck.push(struck);
                }
            }
            // `fill` is refused for as long as the file system is too large. The other kinds fail
            // for a moment only, as while a process restarts.
            None if kind == FaultKind::Fill && !self.impossible.contains(&kind) => {
                self.impossible.push(kind);
            }
            None => {}
        }
    }

    /// Exponentially distributed, as independent faults are.
    fn pause_ns(&mut self) -> u64 {
        // `share` can be 0, of which the logarithm is infinite, but never 1.
        let share = 1.0 - self.random.share();
        nanos(-share.ln() * self.mean_ns / SECOND_NS as f64)
    }

    fn note_recoveries(&mut self, live: &LiveCell, now_ns: u64) {
        let recoveries = &mut self.recoveries_ms;
        self.struck.retain(|struck| {
            let took_ns = now_ns - struck.since_ns;
            let is_back = works_since(live, struck.process) > struck.generation;
            if is_back || took_ns > LONGEST_NS {
                recoveries.push(took_ns as f64 * 1.0e-6);
            }
            // One that was stopped too shortly to be replaced has nothing to recover from.
            let was_gone = is_back || live.generation(struck.process) > struck.generation;
            // A stop lasts 2.5 s at most.
            let is_short = took_ns > 3 * SECOND_NS && !was_gone;
            !(is_back || is_short || took_ns > LONGEST_NS)
        });
    }

    fn end_of_job(&mut self) {
        // Dropping the old value ends its busy loops and removes the file that fills the disk.
        self.faults = Faults::new(self.only);
        // The next cell counts the starts of its processes from the first one: these numbers mean
        // nothing there.
        self.struck.clear();
        self.next_ns = 0;
    }
}

/// The newest start of `process` whose work was seen: a state, a decision, a sign of
/// life.
fn works_since(live: &LiveCell, process: Process) -> u32 {
    let watch = live.watch();
    let work = match process {
        Process::Physics => watch.state().map(|state| state.header.generation),
        Process::Task => watch.decision().map(|decision| decision.header.generation),
        Process::Controller(_) | Process::Monitor => {
            watch.health(process).map(|health| health.header.generation)
        }
    };
    work.unwrap_or(0)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the command line allows positive times of a day"
)]
fn nanos(seconds: f64) -> u64 {
    (seconds * SECOND_NS as f64) as u64
}
