//! The command line of `cell-sim`; people use `robocell`, which passes on what
//! stands here.

use std::io::Write as _;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::process::ExitCode;

use cell_model::Data;
use cell_model::run_spec::RunSpec;
use cell_model::summary::{RunOutcome, RunSummary};
use cell_sim::behaviour::Kind;
use cell_sim::verify::{Report, Verdict, verify_file};
use cell_sim::{SimError, behaviour, bench, eval, run};
use clap::{Parser, Subcommand};

/// A task that failed or timed out; a recording that differs.
const TASK_FAILED: u8 = 5;

#[derive(Parser)]
#[command(name = "cell-sim", about = "The cores of a cell in one process")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Run a cell to its end.
    Run {
        /// The run file.
        #[arg(long)]
        spec: PathBuf,
        /// Print the summary as one JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Run many seeds, one row each.
    Eval {
        /// Name of the demo.
        demo: String,
        /// First and last seed.
        #[arg(long, value_parser = seeds)]
        seeds: RangeInclusive<u64>,
        /// Policy; the cell's default where missing.
        #[arg(long)]
        policy: Option<String>,
        /// Runs at the same time.
        #[arg(long, default_value_t = 1)]
        jobs: usize,
        /// Folder with cells/ and robots/.
        #[arg(long)]
        data: Option<PathBuf>,
        /// A script for every run.
        #[arg(long)]
        script: Option<PathBuf>,
        /// Rows as JSON objects.
        #[arg(long)]
        json: bool,
    },
    /// Look at a behaviour.
    Behaviour {
        /// What to do.
        #[command(subcommand)]
        verb: BehaviourVerb,
    },
    /// Print the JSON Schema of a kind of file.
    Schema {
        /// tree, machine or cell.
        what: String,
    },
    /// Compute a recorded run again and compare it bit for bit.
    Verify {
        /// The recording, or the directory of a flight recorder.
        file: PathBuf,
        /// Folder with cells/ and robots/; that of the run where missing.
        #[arg(long)]
        data: Option<PathBuf>,
        /// One JSON object.
        #[arg(long)]
        json: bool,
    },
    /// Cost of a core.
    Bench {
        /// control or physics.
        what: String,
        /// One JSON object.
        #[arg(long)]
        json: bool,
    },
}

#[derive(Subcommand)]
enum BehaviourVerb {
    /// Print it.
    Show {
        /// bt or fsm.
        #[arg(value_parser = kind)]
        kind: Kind,
        /// A demo or a file.
        what: String,
        /// text, mermaid or dot.
        #[arg(long, default_value = "text")]
        format: String,
        /// Policy of the demo.
        #[arg(long)]
        policy: Option<String>,
        /// Folder with cells/ and robots/.
        #[arg(long)]
        data: Option<PathBuf>,
    },
    /// Say what is wrong in a file, and what is probably not meant.
    Check {
        /// bt or fsm.
        #[arg(value_parser = kind)]
        kind: Kind,
        /// The file.
        file: PathBuf,
    },
}

/// Prints a line. Whom it is for may have gone (`| head`): that is no failure.
fn say(line: std::fmt::Arguments<'_>) {
    writeln!(std::io::stdout().lock(), "{line}").ok();
}

fn kind(word: &str) -> Result<Kind, String> {
    match word {
        "bt" => Ok(Kind::Tree),
        "fsm" => Ok(Kind::Machine),
        _ => Err("there are bt and fsm".to_owned()),
    }
}

fn seeds(text: &str) -> Result<RangeInclusive<u64>, String> {
    let hint = || format!("{text:?} is no range of seeds; write 1..50");
    let (first, last) = text.split_once("..").ok_or_else(hint)?;
    let last = last.strip_prefix('=').unwrap_or(last);
    let parse = |part: &str| part.parse::<u64>().map_err(|_not_a_number| hint());
    let range = parse(first)?..=parse(last)?;
    if range.is_empty() {
        Err(hint())
    } else {
        Ok(range)
    }
}

pub(crate) fn run() -> Result<ExitCode, SimError> {
    match Cli::parse().command {
        Command::Run { spec, json } => {
            let spec = RunSpec::load(&spec)?;
            let summary = run::to_the_end(&spec, |tick, line| {
                if !json {
                    say(format_args!("{:9.3} s  {line}", tick as f64 * 1.0e-3));
                }
            })?;
            print_summary(&summary);
            Ok(code(summary.outcome == RunOutcome::Done))
        }
        Command::Eval {
            demo,
            seeds,
            policy,
            jobs,
            data,
            script,
            json,
        } => {
            let mut spec = eval::template(&demo, policy.as_deref().unwrap_or_default());
            spec.data_dir = data;
            let cell = run::cell_of(&spec)?;
            if let Some(path) = script {
                spec.script = run::script(&path, &cell)?;
            }
            if spec.policy.is_empty() {
                spec.policy = cell.default_policy;
            }
            evaluate(&eval::Plan { spec, seeds, jobs }, json)
        }
        Command::Behaviour { verb } => look(verb),
        Command::Schema { what } => {
            let schema = behaviour::schema(&what)?;
            say(format_args!("{schema:#}"));
            Ok(ExitCode::SUCCESS)
        }
        Command::Verify { file, data, json } => {
            let report = verify_file(&file, data)?;
            print_report(&report, json);
            Ok(code(report.verdict() == Verdict::Same))
        }
        Command::Bench { what, json } => {
            bench::run(&what, json)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn look(verb: BehaviourVerb) -> Result<ExitCode, SimError> {
    match verb {
        BehaviourVerb::Show {
            kind,
            what,
            format,
            policy,
            data,
        } => {
            let data = data.map_or_else(cell_files::data, Data::dir);
            let graphs = behaviour::graphs(kind, &what, policy.as_deref(), &data)?;
            say(format_args!(
                "{}",
                behaviour::draw(&graphs, &format).trim_end()
            ));
        }
        BehaviourVerb::Check { kind, file } => {
            let findings = behaviour::check(kind, &file)?;
            for finding in &findings {
                say(format_args!("warning: {finding}"));
            }
            say(format_args!(
                "{}: no errors, {} warnings",
                file.display(),
                findings.len()
            ));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn evaluate(plan: &eval::Plan, json: bool) -> Result<ExitCode, SimError> {
    let (done, all) = eval::evaluate(plan, |row| {
        if json {
            print_summary(row);
        } else {
            say(format_args!(
                "seed {:5}  {:8}  {:6.2} s  placed {}  drops {}  resyncs {}  aborts {}  violations {}  {}",
                row.seed,
                format!("{:?}", row.outcome).to_lowercase(),
                row.sim_time_s,
                row.placed.len(),
                row.drops,
                row.resyncs,
                row.aborts,
                row.limit_violations,
                row.reason.as_deref().unwrap_or_default(),
            ));
        }
    })?;
    if !json {
        say(format_args!("{done} of {all} done"));
    }
    Ok(code(done == all))
}

fn code(done: bool) -> ExitCode {
    if done {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(TASK_FAILED)
    }
}

fn print_report(report: &Report, json: bool) {
    if !json {
        say(format_args!("{report}"));
        return;
    }
    let verdict = report.verdict();
    say(format_args!(
        "{}",
        serde_json::json!({ "verdict": verdict, "report": report })
    ));
}

fn print_summary(summary: &RunSummary) {
    match serde_json::to_string(summary) {
        Ok(line) => say(format_args!("{line}")),
        Err(error) => eprintln!("cell-sim: the summary cannot be written: {error}"),
    }
}
