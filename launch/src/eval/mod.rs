//! `robocell eval`: runs seeds by the task program, merges rows and reports them.

mod merged;
mod page;

use std::path::{Path, PathBuf};

use cell_model::cells::sweep::{Bounds, Values};
use cell_model::runs::policy_server::{Fault, is_address};
use cell_model::user_file;
use cell_run::python;
use evaluation::report::{Gate, Reports, report};
use supervisor::failure::{Code, Context as _, Failure};

use crate::args::server::ServerArgs;
use crate::args::{EpisodeArgs, EvalArgs, EvalVerb, ReportRowsArgs};
use crate::run::plan;
use crate::run::plan::server::not_for;
use crate::{say, task_program};

/// Does what the arguments say.
pub(crate) fn run(args: &EvalArgs) -> Result<(), Failure> {
    match &args.verb {
        Some(EvalVerb::Merge(merge)) => merged::print(&merge.files),
        Some(EvalVerb::Report(report)) => report_files(report),
        None => run_seeds(args),
    }
}

/// Runs seeds by the task program, in place of this process.
fn run_seeds(args: &EvalArgs) -> Result<(), Failure> {
    // The command line requires both.
    let demo = args.demo.as_deref().unwrap_or_default();
    let mut order = Order::of(&args.episodes, demo, args.seeds.unwrap_or_default())?;
    order.add("--rate", args.rate.map(|rate| rate.to_string()));
    order.add("--record", args.record.as_deref().map(path));
    let ServerArgs {
        names,
        keep_answers,
        answers,
    } = &args.server;
    let policy = args.episodes.policy.as_deref().unwrap_or("the default");
    let is_given = names.is_some() || keep_answers.is_some() || answers.is_some();
    if !is_address(policy) {
        not_for(
            policy,
            is_given || !args.latency_ms.is_empty() || !args.fault.is_empty(),
        )?;
    }
    order.add("--frame-hash", args.frame_hash.iter().cloned());
    order.add("--latency-ms", args.latency_ms.iter().map(u32::to_string));
    order.add("--fault", args.fault.iter().map(Fault::to_string));
    order.add("--names", names.as_deref().map(path));
    order.add("--keep-answers", keep_answers.as_deref().map(path));
    order.add("--answers", answers.as_deref().map(path));
    if let Some(out) = &args.out {
        order.add("--out", Some(path(out)));
        order.add("--shard", Some(args.shard.to_string()));
        // What runs a Python file is the same for all of them.
        let program = order.program.as_deref();
        let file = program.filter(|program| python::is_file(program)).map(path);
        order.add("--input", file);
        order.add("--named-task", args.episodes.data.program.task.clone());
        if let Some(dir) = &args.record_failures {
            // A recording is made by a run of the whole cell, which only this program starts.
            let own = std::env::current_exe().cannot("find this program")?;
            order.add("--record-failures", Some(path(dir)));
            order.add("--launcher", Some(path(&own)));
        }
    }
    order.run(args.json)
}

fn path(path: &Path) -> String {
    path.display().to_string()
}

/// A rule, or the absolute path of a file of them: a recording is made elsewhere.
fn absolute_rule(argument: &String) -> String {
    let path = std::fs::canonicalize(argument).ok();
    path.filter(|path| path.extension().is_some_and(|e| e == "jsonl"))
        .map_or_else(|| argument.clone(), |path| path.display().to_string())
}

/// What the task program is told.
struct Order {
    program: Option<PathBuf>,
    arguments: Vec<String>,
}

impl Order {
    /// Names are checked here, so that a typo is answered before anything starts.
    fn of(args: &EpisodeArgs, demo: &str, seeds: (u64, u64)) -> Result<Self, Failure> {
        let data = args.data.data.as_deref();
        let found =
            |dir: &Path| std::fs::canonicalize(dir).cannot(format!("find {}", dir.display()));
        // As `run` has it, so that both name a file in the same way.
        let data = data.map(found).transpose()?;
        let data = data.as_deref();
        let robot = plan::cell::robot_files(&args.robot, data)?;
        // Only the names of its program and policies are used, so any seed will do.
        let cell = plan::cell::load(data, demo, seeds.0, robot.as_ref(), &[])?;
        let program = task_program::of_cell(args.data.program.task.as_deref(), &cell, data)?;
        let policy = plan::policy::policy_name(args.policy.as_deref(), &cell, program.as_deref())?;
        let mut order = Self {
            program,
            arguments: vec!["eval".to_owned(), demo.to_owned()],
        };
        order.add("--seeds", Some(format!("{}..{}", seeds.0, seeds.1)));
        order.add("--policy", Some(policy));
        order.add("--jobs", Some(args.jobs.to_string()));
        order.add("--timeout", args.job.timeout.map(|limit| limit.to_string()));
        order.add("--bins", args.job.bins.map(|bins| bins.to_string()));
        order.add("--script", args.job.script.as_deref().map(path));
        order.add("--set", args.set.iter().map(Values::to_string));
        order.add("--replace", args.job.replace.iter().map(absolute_rule));
        order.add("--vary", args.vary.iter().map(Bounds::to_string));
        if let Some(robot) = &robot {
            let robot = serde_json::to_string(robot).cannot("name the robot")?;
            order.add("--robot", Some(robot));
        }
        order.add("--data", data.map(path));
        Ok(order)
    }

    /// Adds an option with each of its values.
    fn add(&mut self, name: &str, values: impl IntoIterator<Item = String>) {
        let pairs = values.into_iter();
        let pairs = pairs.flat_map(|value| [name.to_owned(), value]);
        self.arguments.extend(pairs);
    }

    fn run(mut self, json: bool) -> Result<(), Failure> {
        self.arguments.extend(json.then(|| "--json".to_owned()));
        let program = self.program.as_deref();
        Err(task_program::become_it(program, &self.arguments))
    }
}

fn report_files(args: &ReportRowsArgs) -> Result<(), Failure> {
    if let Some(path) = &args.html {
        // Before the rows are read: a path that cannot be written is refused at once.
        user_file::check_output(path).cannot(format!("write {}", path.display()))?;
    }
    let mut reports = report(&args.file, args.other.as_deref()).map_err(Failure::configuration)?;
    if args.gate {
        reports.decide(args.loss);
    }
    if let Some(path) = &args.html {
        let page = page::page(&reports).map_err(Failure::configuration)?;
        std::fs::write(path, page).cannot(format!("write {}", path.display()))?;
    }
    if args.json {
        say::line(serde_json::to_string(&reports).cannot("print the report")?);
        return gated(&reports, true);
    }
    for file in &reports.files {
        say::line(file);
    }
    if let Some(comparison) = &reports.comparison {
        say::line(comparison);
    }
    gated(&reports, false)
}

/// The end of a report with a gate; `is_said` where its sentence was printed.
fn gated(reports: &Reports, is_said: bool) -> Result<(), Failure> {
    let Some(gate) = &reports.gate else {
        return Ok(());
    };
    let code = match gate {
        Gate::Passed { .. } => None,
        Gate::Worse { .. } => Some(Code::Worse),
        Gate::TooFew { .. } => Some(Code::Configuration),
    };
    if !is_said {
        say::line(format_args!("  {gate}"));
    }
    code.map_or(Ok(()), |code| Err(Failure::silent(code)))
}
