//! `eval`: many seeds, printed or written as rows.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::process::ExitCode;

use cell_model::cells::replace::of_arguments;
use cell_model::cells::setting::{Setting, by_key};
use cell_model::cells::sweep::{Bounds, Case, Sweep, Values};
use cell_model::runs::policy_server::{Fault, PolicyServer, is_address, read_names};
use cell_model::{Cell, RobotFiles};
use cell_run::report;
use cell_run::spec::RunSpec;
use cell_run::summary::RunSummary;
use cell_sim::action::Hold;
use cell_sim::eval::EvalRun;
use cell_sim::{Program, SimError, episodes, eval, run};
use clap::Args;
use evaluation::shard::Shard;
use robocell_task::Task;

use crate::exit::STOPPED;
use crate::failure::CliError;
use crate::inspect;
use crate::output::{counted, print_json, print_line};
use crate::progress::Progress;
use crate::reached::{self, Reached};
use crate::recordings::Recordings;
use crate::rows::{self, Order, RowsError};
use crate::warned::Warned;

/// What to run.
#[derive(Args)]
pub(crate) struct EvalArgs {
    /// Name of the demo.
    pub(crate) demo: String,
    /// First and last seed.
    #[arg(long, value_parser = seeds)]
    pub(crate) seeds: RangeInclusive<u64>,
    /// Policy; the cell's default where missing.
    #[arg(long)]
    pub(crate) policy: Option<String>,
    /// Runs at the same time.
    #[arg(long, default_value_t = 1)]
    pub(crate) jobs: usize,
    /// Folder with cells/ and robots/.
    #[arg(long)]
    pub(crate) data: Option<PathBuf>,
    /// A script for every run.
    #[arg(long)]
    pub(crate) script: Option<PathBuf>,
    /// Time limit of a run (simulated s).
    #[arg(long)]
    pub(crate) timeout: Option<f64>,
    /// Bins the job is about.
    #[arg(long)]
    pub(crate) bins: Option<u32>,
    /// Numbers in place of those of the cell file.
    #[arg(long)]
    pub(crate) set: Vec<Values>,
    /// Numbers that are drawn for each seed.
    #[arg(long)]
    pub(crate) vary: Vec<Bounds>,
    /// Leaves that answer without being run, as for `robocell run`.
    #[arg(long)]
    pub(crate) replace: Vec<String>,
    /// Rate of the actions (Hz).
    #[arg(long)]
    pub(crate) rate: Option<u32>,
    /// Cameras whose last picture is hashed.
    #[arg(long)]
    pub(crate) frame_hash: Vec<String>,
    /// Latencies of a policy server (ms).
    #[arg(long)]
    pub(crate) latency_ms: Vec<u32>,
    /// Faults of its observations.
    #[arg(long)]
    pub(crate) fault: Vec<Fault>,
    /// File with the names of its observations.
    #[arg(long)]
    pub(crate) names: Option<PathBuf>,
    /// Folder for its answers.
    #[arg(long)]
    pub(crate) keep_answers: Option<PathBuf>,
    /// Folder with answers in its place.
    #[arg(long)]
    pub(crate) answers: Option<PathBuf>,
    /// Folder for recordings of all episodes.
    #[arg(long)]
    pub(crate) record: Option<PathBuf>,
    /// A robot of the user, as the JSON of its files.
    #[arg(long)]
    pub(crate) robot: Option<String>,
    /// File for the rows.
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// The shard of the seeds.
    #[arg(long, requires = "out", default_value = "1/1")]
    pub(crate) shard: Shard,
    /// A file that runs depend on as well.
    #[arg(long)]
    pub(crate) input: Vec<PathBuf>,
    /// `--task` of the launcher.
    #[arg(long)]
    pub(crate) named_task: Option<String>,
    /// Folder for recordings of episodes that do not end done.
    #[arg(long, requires = "launcher")]
    pub(crate) record_failures: Option<PathBuf>,
    /// The launcher, which records them.
    #[arg(long)]
    pub(crate) launcher: Option<PathBuf>,
    /// Rows as JSON objects.
    #[arg(long)]
    pub(crate) json: bool,
}

impl EvalArgs {
    /// Arguments with which `robocell run` repeats one of the episodes.
    fn of_run(&self, robot: Option<&RobotFiles>) -> Vec<String> {
        let path = |path: &PathBuf| path.display().to_string();
        let robot = robot.into_iter().flat_map(|robot| {
            let files = [
                ("--robot", Some(&robot.urdf)),
                ("--xrdf", robot.xrdf.as_ref()),
                ("--rmpflow", robot.rmpflow.as_ref()),
            ];
            let files = files.map(|(name, file)| (name, file.map(path)));
            files.into_iter().chain([("--tip", robot.tip.clone())])
        });
        let options = [
            ("--data", self.data.as_ref().map(path)),
            ("--script", self.script.as_ref().map(path)),
            ("--timeout", self.timeout.map(|limit| limit.to_string())),
            ("--bins", self.bins.map(|bins| bins.to_string())),
            ("--task", self.named_task.clone()),
            ("--names", self.names.as_ref().map(path)),
        ];
        let replace = self
            .replace
            .iter()
            .map(|rule| ("--replace", Some(rule.clone())));
        let given = options.into_iter().chain(robot).chain(replace);
        let given = given.filter_map(|(name, value)| Some([name.to_owned(), value?]));
        given.flatten().collect()
    }
}

/// Runs all seeds.
pub(crate) fn run(program: &Program, args: EvalArgs) -> Result<ExitCode, CliError> {
    let robot: Option<RobotFiles> = args
        .robot
        .as_deref()
        .map(serde_json::from_str)
        .transpose()?;
    let arguments = args.of_run(robot.as_ref());
    let plan = plan(program, &args, robot)?;
    if let Some(dir) = &plan.record {
        // A first error for all, in place of one by each episode.
        std::fs::create_dir_all(dir).map_err(|source| SimError::from_dir(dir, source))?;
    }
    let Some(out) = args.out else {
        return Ok(evaluate(program, &plan, args.json)?);
    };
    let order = Order {
        spec: &plan.spec,
        cases: &plan.cases,
        seeds: [*plan.seeds.start(), *plan.seeds.end()],
        shard: args.shard,
        jobs: plan.jobs,
        record: plan.record.as_deref(),
        out: &out,
        inputs: &args.input,
        arguments,
    };
    // Rows first: recordings are made of the failed rows in the file, so they may also be made
    // of rows that an earlier, stopped command wrote.
    let code = write_rows(program, &order, args.json)?;
    if let (Some(dir), Some(launcher)) = (&args.record_failures, &args.launcher) {
        let recordings = Recordings {
            dir,
            launcher,
            answers: args.keep_answers.as_deref().or(args.answers.as_deref()),
            names: (&plan.spec.demo, &plan.spec.policy),
            arguments: &order.arguments,
        };
        let made = recordings.of(&out)?;
        if !args.json {
            print_line(format_args!(
                "{}: recorded {made} failed episodes",
                dir.display()
            ));
        }
    }
    Ok(code)
}

/// The episodes, after the files that they depend on were read.
fn plan(
    program: &Program,
    args: &EvalArgs,
    robot: Option<RobotFiles>,
) -> Result<eval::Plan, SimError> {
    let mut spec = eval::template(&args.demo, args.policy.as_deref().unwrap_or_default());
    spec.data_dir.clone_from(&args.data);
    (spec.time_limit_s, spec.bins) = (args.timeout, args.bins);
    // The first seed represents all: only files and names are checked with it.
    (spec.robot, spec.seed) = (robot, *args.seeds.start());
    spec.replace = of_arguments(&args.replace)?;
    // A wrong rate is refused here, not by each episode.
    args.rate.map(Hold::new).transpose()?;
    spec.action_hz = args.rate;
    spec.policy_server = server(args)?;
    spec.frame_hash.clone_from(&args.frame_hash);
    let cell = spec.load_cell_from(&program.data)?;
    if let Some(path) = &args.script {
        spec.script = run::script(path, &cell)?;
    }
    // The name goes into every row and into the identity of the rows: a default that changes in
    // the cell file must not leave it empty.
    if spec.policy.is_empty() {
        program
            .policies
            .default_policy(&cell)
            .clone_into(&mut spec.policy);
    }
    warn_of_inputs(program, &spec, &cell)?;
    let sweep = Sweep {
        set: args.set.clone(),
        vary: args.vary.clone(),
        latencies_ms: args.latency_ms.clone(),
        faults: args.fault.clone(),
    };
    Ok(eval::Plan {
        cases: episodes::cases(program, &spec, sweep)?,
        spec,
        seeds: args.seeds.clone(),
        jobs: args.jobs,
        record: args.record.clone(),
    })
}

/// The use of a policy server, for all episodes.
fn server(args: &EvalArgs) -> Result<Option<PolicyServer>, SimError> {
    if !args.policy.as_deref().is_some_and(is_address) {
        return Ok(None);
    }
    // One error for all, in place of one by each episode.
    if let Some(dir) = &args.keep_answers {
        std::fs::create_dir_all(dir).map_err(|source| SimError::from_dir(dir, source))?;
    }
    if let Some(dir) = &args.answers {
        let path = dir.clone();
        std::fs::metadata(dir).map_err(|source| SimError::Answers { path, source })?;
    }
    let names = args.names.as_deref().map(read_names).transpose()?;
    Ok(Some(PolicyServer {
        names: names.unwrap_or_default(),
        keep: args.keep_answers.clone(),
        answers: args.answers.clone(),
        ..PolicyServer::default()
    }))
}

/// Prints the warnings that `run` has about the same files, once for all episodes.
fn warn_of_inputs(program: &Program, spec: &RunSpec, cell: &Cell) -> Result<(), SimError> {
    report::of_cell(cell).iter().for_each(cell_worker::warn);
    // A refused task is refused by each seed, unless a sweep changes it.
    let task = program.policies.task(cell, &spec.policy);
    let warnings = task.as_ref().map(Task::warnings).unwrap_or_default();
    warnings.iter().for_each(cell_worker::warn);
    if !spec.script.is_empty() {
        // A script may name phases that the policy does not have, which needs its pictures.
        let task = task?;
        let drawing = inspect::draw(task.graphs(), "text", usize::MAX);
        let warnings = report::of_script(&spec.script, &drawing, cell);
        warnings.iter().for_each(cell_worker::warn);
    }
    Ok(())
}

fn seeds(text: &str) -> Result<RangeInclusive<u64>, String> {
    // `1..50` is inclusive here, and `1..=50`, as Rust writes it, means the same.
    let hint = || format!("{text:?} is not a range of seeds; write 1..50");
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

fn evaluate(program: &Program, plan: &eval::Plan, json: bool) -> Result<ExitCode, SimError> {
    let progress = Progress::of_runs(plan.episodes());
    let (warned, reached) = (Warned::default(), Reached::default());
    let print = |case: &Case, row: &RunSummary| {
        if json {
            print_json(&EvalRun {
                summary: row.clone(),
                set: by_key(&case.settings()),
            });
            return;
        }
        let set = case.settings();
        let set = set.iter().map(Setting::to_string);
        let latency = case.latency_ms.map(|ms| format!("latency {ms} ms"));
        let fault = case.fault.as_ref().map(|fault| format!("fault {fault}"));
        let set: Vec<String> = set.chain(latency).chain(fault).collect();
        let line = format!(
            "seed {:5}  {:8}  {:6.2} s  placed {}  drops {}  resyncs {}  aborts {}  violations {}  {}  {}",
            row.seed,
            format!("{:?}", row.outcome).to_lowercase(),
            row.sim_time_s,
            row.placed.len(),
            row.drops,
            row.resyncs,
            row.aborts,
            row.limit_violations,
            row.reason.as_deref().unwrap_or_default(),
            set.join("  "),
        );
        print_line(format_args!("{}", line.trim_end()));
        if let Some(message) = &row.message {
            print_line(format_args!("            [fault] {message}"));
        }
    };
    let counts = eval::evaluate(program, plan, |ended| {
        reached.count(&ended.result);
        // Printed while the progress line is removed: otherwise both would be on one line.
        progress.run(|| {
            warned.show(&ended.warnings);
            match &ended.result {
                Ok(summary) => print(&ended.case, summary),
                Err(why) => cell_worker::warn(format_args!("seed {}: {why}", ended.case.seed)),
            }
        });
    })?;
    // Before the last line, which the progress line would overwrite.
    drop(progress);
    if json {
        print_json(&counts);
    } else {
        print_line(format_args!("{} of {} done", counts.done, counts.runs));
    }
    Ok(reached.code(&plan.spec.policy))
}

/// Writes the rows of a shard; a command that was stopped is repeated to resume.
fn write_rows(program: &Program, order: &Order<'_>, json: bool) -> Result<ExitCode, RowsError> {
    let written = rows::write(program, order)?;
    let (new, failed) = written.new;
    if json {
        print_json(&serde_json::json!({
            "out": order.out, "rows": written.rows, "of": written.all,
            "new": new, "new_not_done": failed,
        }));
    } else {
        print_line(format_args!(
            "{}: {} of {}; {} now, {failed} of them not done",
            order.out.display(),
            written.rows,
            counted(written.all, "row"),
            counted(new, "episode")
        ));
    }
    // Rows may be missing after a signal only; the file is then not sorted (ADR 0023).
    if written.rows == written.all {
        return Ok(reached::code_of_rows(order, &written)?);
    }
    let left = counted(written.all - written.rows, "row");
    cell_worker::warn(format_args!(
        "stopped with {left} left; the same command resumes"
    ));
    Ok(ExitCode::from(STOPPED))
}
