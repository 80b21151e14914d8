//! `robocell chaos`: jobs back to back, and faults while they run.

mod fault;
mod random;
mod report;

use cell_rt::clock::monotonic_ns;
use cell_rt::signal::stop_requested;
use clap::Parser;
use ipc_types::topic::Process;

use crate::cli::{ChaosArgs, Cli, Command};
use crate::failure::{Code, Failure};
use crate::leftovers::Leftovers;
use crate::run::{End, LiveCell, Plan};
use crate::{output, say};
pub use fault::FaultKind;
use fault::{Begun, Faults, Struck};
use random::Random;
use report::Recovery;
pub(crate) use report::Report;

const SECOND_NS: u64 = 1_000_000_000;
/// A process that is not back after this is counted with it (ns).
const LONGEST_NS: u64 = 30 * SECOND_NS;

/// Does what the command line says.
pub(crate) fn chaos(args: &ChaosArgs) -> Result<(), Failure> {
    let end_ns = monotonic_ns() + nanos(args.minutes * 60.0);
    let mut report = Report::new(&args.demo, args.seed, args.minutes);
    for kind in &args.faults {
        report.faults.insert(word(*kind), 0);
    }
    let mut injector = Injector::new(args, end_ns);
    let mut job = 0;
    while monotonic_ns() < end_ns && !stop_requested() {
        let plan = plan(args, args.seed + job)?;
        job += 1;
        let dir = plan.dir.clone();
        let live = LiveCell::start(plan)?;
        let end = live.stay(|live| injector.turn(live, &mut report));
        injector.end_of_job();
        report.leftovers += Leftovers::find(&dir).count();
        match end {
            End::Finished(summary) => report.job(&summary),
            End::GaveUp(failure) => {
                report.jobs_failed += 1;
                say::warn(format_args!("job {job}: {failure}"));
            }
            End::Stopped(_) | End::Replaced(_) => {}
        }
        if !args.json {
            say::line(format_args!(
                "job {job}: {} finished, {} failed, {} parts lost",
                report.jobs_done, report.jobs_failed, report.parts_lost
            ));
        }
    }
    report.recovery_ms = Recovery::of(injector.recoveries_ms);
    if args.json {
        output::print(&report)?;
    } else {
        say::raw(report.table().as_bytes());
        injector.impossible.iter().for_each(|kind| {
            say::line(format_args!("note: {} could not be done here", word(*kind)));
        });
    }
    let is_bad = report.jobs_failed > 0 || report.parts_lost > 0 || report.leftovers > 0;
    if is_bad {
        return Err(Failure::silent(Code::TaskFailed));
    }
    Ok(())
}

/// The run of one job, as `robocell run` would have it.
fn plan(args: &ChaosArgs, seed: u64) -> Result<Plan, Failure> {
    let seed = seed.to_string();
    let mut words = vec!["robocell", "run", &args.demo, "--headless", "--until-done"];
    words.extend(["--seed", &seed, "--cell", &args.cell]);
    if let Some(policy) = &args.policy {
        words.extend(["--policy", policy]);
    }
    let mut cli = Cli::try_parse_from(words).map_err(Failure::usage)?;
    match &mut cli.command {
        Command::Run(run) => {
            run.data = args.data.clone();
            Plan::resolve(run)
        }
        _ => Err(Failure::usage("no run")),
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
    faults: Faults,
    struck: Vec<Struck>,
    recoveries_ms: Vec<f64>,
    impossible: Vec<FaultKind>,
}

impl Injector {
    fn new(args: &ChaosArgs, end_ns: u64) -> Self {
        Self {
            kinds: args.faults.clone(),
            mean_ns: 60.0e9 / args.rate,
            end_ns,
            random: Random::new(args.seed),
            next_ns: 0,
            faults: Faults::default(),
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
            None if kind == FaultKind::Fill && !self.impossible.contains(&kind) => {
                self.impossible.push(kind);
            }
            None => {}
        }
    }

    /// Exponentially distributed, as independent faults are.
    fn pause_ns(&mut self) -> u64 {
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
            let is_short = took_ns > 3 * SECOND_NS && !was_gone;
            !(is_back || is_short || took_ns > LONGEST_NS)
        });
    }

    fn end_of_job(&mut self) {
        self.faults = Faults::default();
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
