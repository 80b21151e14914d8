//! The command line of a task program; users call `robocell`, which forwards its
//! arguments.

use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cell_model::Data;
use cell_model::cells::replace::Replace;
use cell_model::cells::setting::Setting;
use cell_record::Recording;
use cell_rt::stdout;
use cell_run::output::schema;
use cell_run::python;
use cell_run::spec::{ENDED_FILE, RunSpec};
use cell_run::summary::RunOutcome;
use cell_sim::eval::EvalLine;
use cell_sim::run::RunMessage;
use cell_sim::verify::{Report, Verdict, Verified, verify_file};
use cell_sim::{Program, SimError, run};
use clap::{Parser, Subcommand};

use crate::around;
use crate::camera::{self, CameraArgs};
use crate::checked::Checked;
use crate::evaluate::{self, EvalArgs};
use crate::exit::{CONFIGURATION, TASK_FAILED};
use crate::failure::CliError;
use crate::inspect::{self, InspectError, Kind};
use crate::output::{counted, print_json, print_line};
use crate::progress::Progress;

#[derive(Parser)]
#[command(about = "A task program: robocell starts it as the task of a cell")]
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
    /// Draw what cameras see.
    Camera(CameraArgs),
    /// Run many seeds, one row each.
    Eval(Box<EvalArgs>),
    /// Pictures and checks of behaviours.
    Behaviour {
        /// What to do.
        #[command(subcommand)]
        verb: BehaviourVerb,
    },
    /// Print the JSON Schema of a kind of file.
    Schema {
        /// tree, machine or cell; eval, verify or check for their JSON output.
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
        /// With the jobs of this program, whichever did the task of the run.
        #[arg(long, hide = true)]
        here: bool,
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
        /// text, mermaid, dot or names.
        #[arg(long, default_value = "text")]
        format: String,
        /// Policy of the demo.
        #[arg(long)]
        policy: Option<String>,
        /// Folder with cells/ and robots/.
        #[arg(long)]
        data: Option<PathBuf>,
        /// Numbers in place of those of the cell file.
        #[arg(long)]
        set: Vec<Setting>,
        /// Leaves that answer without being run, as JSON.
        #[arg(long)]
        replace: Option<String>,
        /// Characters of a line, for tables; no limit where missing.
        #[arg(long)]
        width: Option<usize>,
    },
    /// Check a file.
    Check {
        /// bt or fsm.
        #[arg(value_parser = kind)]
        kind: Kind,
        /// The file.
        file: PathBuf,
        /// One JSON object.
        #[arg(long)]
        json: bool,
    },
}

fn kind(word: &str) -> Result<Kind, String> {
    match word {
        "bt" => Ok(Kind::Tree),
        "fsm" => Ok(Kind::Machine),
        _ => Err("there are bt and fsm".to_owned()),
    }
}

/// Runs the subcommand.
pub(crate) fn main(program: &Program, words: &[String]) -> ExitCode {
    let fail = |text: &dyn std::fmt::Display| {
        writeln!(std::io::stderr(), "{text}").ok();
        ExitCode::from(CONFIGURATION)
    };
    let code = run(program, words).unwrap_or_else(|error| fail(&error));
    // A script would take a truncated result for the whole one.
    let written = stdout::finish();
    let unwritten = written.map_err(|error| {
        fail(&format_args!(
            "robocell: cannot write to standard output: {error}"
        ))
    });
    match unwritten {
        // A failed task keeps its own code: its result is the more important one.
        Err(refused) if code == ExitCode::SUCCESS => refused,
        _ => code,
    }
}

fn run(program: &Program, words: &[String]) -> Result<ExitCode, CliError> {
    let own_name = std::iter::once("task program");
    let cli = Cli::parse_from(own_name.chain(words.iter().map(String::as_str)));
    match cli.command {
        Command::Run { spec, json } => {
            let code = run_file(program, &spec, json);
            // The launcher takes an exit without this file for one that a policy called.
            std::fs::write(spec.with_file_name(ENDED_FILE), "").ok();
            code
        }
        Command::Camera(args) => {
            let code = camera::run(program, &args);
            // As for `run`: this exit is not one that a policy called.
            std::fs::write(args.spec.with_file_name(ENDED_FILE), "").ok();
            Ok(code?)
        }
        Command::Eval(args) => evaluate::run(program, *args),
        Command::Behaviour { verb } => Ok(inspect(program, verb)?),
        Command::Schema { what } => {
            // The schemas of output first: their names are fixed, the others are kinds of
            // files.
            let schema = match output_schema(&what) {
                // files.
                Some(schema) => schema,
                None => inspect::schema(program, &what)?,
            };
            print_line(format_args!("{schema:#}"));
            Ok(ExitCode::SUCCESS)
        }
        Command::Verify {
            file,
            data,
            json,
            here,
        } => {
            // The jobs of the run may be in another program, whose policies this one does not
            // have.
            if let Some(other) = recorded_program(&file).filter(|_| !here) {
                return Ok(verify_by(&other, words)?);
            }
            Ok(verify(program, &file, data, json)?)
        }
    }
}

fn run_file(program: &Program, path: &Path, json: bool) -> Result<ExitCode, CliError> {
    let spec = RunSpec::load(path)?;
    Ok(run_once(program, &spec, json)?)
}

fn run_once(program: &Program, spec: &RunSpec, json: bool) -> Result<ExitCode, SimError> {
    let summary = run::to_the_end(program, spec, |said| match said {
        // With `--json` the only output is the summary: a line of the log would break a parser.
        RunMessage::Line(tick, line) if !json => {
            print_line(format_args!("{:9.3} s  {line}", tick as f64 * 1.0e-3));
        }
        RunMessage::Line(..) => {}
        RunMessage::Warning(warning) => cell_worker::warn(warning),
    })?;
    if json {
        print_json(&summary);
    } else {
        print_line(format_args!("{summary}"));
    }
    Ok(code(summary.outcome == RunOutcome::Done))
}

fn verify(
    program: &Program,
    file: &Path,
    data: Option<PathBuf>,
    json: bool,
) -> Result<ExitCode, SimError> {
    let progress = Progress::of_time("verify");
    let report = verify_file(program, file, data, &|tick| progress.tick(tick))?;
    // The spinner is removed before the report: both are on the same terminal line.
    drop(progress);
    print_report(&report, json);
    Ok(code(report.verdict() == Verdict::Same))
}

fn inspect(program: &Program, verb: BehaviourVerb) -> Result<ExitCode, InspectError> {
    match verb {
        BehaviourVerb::Show {
            kind,
            what,
            format,
            policy,
            data,
            set,
            replace,
            width,
        } => {
            // The robots of the built-in data remain available to cells in the folder of a
            // user.
            let data = data.map(|dir| Data::dir(dir).with_robots_of(&program.data));
            let data = data.unwrap_or_else(|| program.data.clone());
            let policy = policy.as_deref();
            let replace: Vec<Replace> = match replace {
                Some(rules) => serde_json::from_str(&rules)
                    .map_err(|error| InspectError::Behaviour(format!("--replace: {error}")))?,
                None => Vec::new(),
            };
            let files = (&data, set.as_slice(), replace);
            let (graphs, warnings) = inspect::graphs(program, kind, &what, policy, files)?;
            // Names are for the completion of a command line.
            if format != "names" {
                warnings.iter().for_each(cell_worker::warn);
            }
            print_line(format_args!(
                "{}",
                inspect::draw(&graphs, &format, width.unwrap_or(usize::MAX)).trim_end()
            ));
        }
        BehaviourVerb::Check { kind, file, json } => return check(program, kind, &file, json),
    }
    Ok(ExitCode::SUCCESS)
}

fn check(program: &Program, kind: Kind, file: &Path, json: bool) -> Result<ExitCode, InspectError> {
    let found = inspect::check(program, kind, file);
    if json {
        // A result for programs is complete also with errors, so that it is printed before the
        // exit code says that the file is refused.
        let checked = Checked::new(file, &found);
        print_json(&checked);
        return Ok(if checked.ok {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(CONFIGURATION)
        });
    }
    let findings = found?;
    for finding in &findings {
        print_line(format_args!("warning: {finding}"));
    }
    print_line(format_args!(
        "{}: no errors, {}",
        file.display(),
        counted(findings.len() as u64, "warning")
    ));
    Ok(ExitCode::SUCCESS)
}

/// The task program of a recorded run, where it is not the built-in one. `None` for a
/// recording that cannot be read: its verification reports why.
fn recorded_program(file: &Path) -> Option<PathBuf> {
    Recording::open(file).ok()?.run().task_program.clone()
}

/// Replaces this process by the program that did the task of the run, with our arguments.
fn verify_by(program: &Path, words: &[String]) -> Result<ExitCode, SimError> {
    let mut command = python::command(program);
    // `--here` ends the recursion: that program finds its own name in the recording, too.
    command.args(words).arg("--here");
    Err(SimError::TaskProgram {
        path: program.display().to_string(),
        // `exec` returns only if it failed.
        source: command.exec(),
    })
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
        print_line(format_args!("{report}{}", around::charts(report)));
        return;
    }
    print_json(&Verified {
        verdict: report.verdict(),
        report,
    });
}

/// The schema of the JSON output of a subcommand.
fn output_schema(what: &str) -> Option<serde_json::Value> {
    match what {
        "eval" => Some(schema::<EvalLine>()),
        "verify" => Some(schema::<Verified<'_>>()),
        "check" => Some(schema::<Checked>()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_help_of_schema_names_all_outputs() {
        let command = Cli::command();
        let schema = command.find_subcommand("schema").unwrap();
        let what = schema.get_arguments().find(|arg| arg.get_id() == "what");
        let help = what.and_then(|arg| arg.get_help()).unwrap().to_string();
        for output in ["eval", "verify", "check"] {
            assert!(output_schema(output).is_some(), "{output}");
            assert!(help.contains(output), "{output} in {help}");
        }
    }
}
