//! `robocell eval`: runs seeds by the task program, merges rows and reports them.

mod merged;
mod page;
mod parquet;

use std::path::Path;

use cell_model::runs::python;
use evaluation::report::report;

use crate::cli::{EvalArgs, EvalVerb, ReportRowsArgs};
use crate::failure::{Context as _, Failure};
use crate::run::plan;
use crate::{say, task_program};

/// Does what the arguments say.
pub(crate) fn run(args: &EvalArgs) -> Result<(), Failure> {
    match &args.verb {
        Some(EvalVerb::Merge(merge)) => merged::write(merge),
        Some(EvalVerb::Report(report)) => report_files(report),
        None => run_seeds(args),
    }
}

/// Names are checked here, so that a typo is answered before anything starts.
fn run_seeds(args: &EvalArgs) -> Result<(), Failure> {
    // The command line requires both.
    let (demo, seeds) = (
        args.demo.as_deref().unwrap_or_default(),
        args.seeds.unwrap_or_default(),
    );
    let data = args.data.data.as_deref();
    let robot = plan::robot_files(&args.robot)?;
    let cell = plan::load(data, demo, seeds.0, robot.as_ref())?;
    let program = task_program::of_cell(args.data.task.as_deref(), &cell, data)?;
    let policy = plan::policy_name(args.policy.as_deref(), &cell, program.as_deref())?;
    let mut arguments = vec!["eval".to_owned(), demo.to_owned()];
    let mut add = |name: &str, value: Option<String>| {
        arguments.extend(value.into_iter().flat_map(|value| [name.to_owned(), value]));
    };
    add("--seeds", Some(format!("{}..{}", seeds.0, seeds.1)));
    add("--policy", Some(policy));
    add("--jobs", Some(args.jobs.to_string()));
    add("--timeout", args.timeout.map(|limit| limit.to_string()));
    add("--bins", args.bins.map(|bins| bins.to_string()));
    let path = |path: &Path| path.display().to_string();
    add("--script", args.script.as_deref().map(path));
    if let Some(out) = &args.out {
        add("--out", Some(path(out)));
        add("--shard", Some(args.shard.to_string()));
        // What runs a Python file is the same for all of them.
        let file = program
            .as_deref()
            .filter(|program| python::is_file(program));
        add("--input", file.map(path));
        add("--named-task", args.data.task.clone());
        if let Some(dir) = &args.record_failures {
            let own = std::env::current_exe().cannot("find this program")?;
            add("--record-failures", Some(path(dir)));
            add("--launcher", Some(path(&own)));
        }
    }
    if let Some(robot) = &robot {
        add(
            "--robot",
            Some(serde_json::to_string(robot).cannot("name the robot")?),
        );
    }
    if let Some(dir) = data {
        let dir = std::fs::canonicalize(dir).cannot(format!("find {}", dir.display()))?;
        add("--data", Some(path(&dir)));
    }
    arguments.extend(args.json.then(|| "--json".to_owned()));
    Err(task_program::become_it(program.as_deref(), &arguments))
}

fn report_files(args: &ReportRowsArgs) -> Result<(), Failure> {
    let reports = report(&args.file, args.other.as_deref()).map_err(Failure::configuration)?;
    if let Some(path) = &args.html {
        let page = page::page(&reports).map_err(Failure::configuration)?;
        std::fs::write(path, page).cannot(format!("write {}", path.display()))?;
    }
    if args.json {
        say::line(serde_json::to_string(&reports).cannot("print the report")?);
        return Ok(());
    }
    for file in &reports.files {
        say::line(file);
    }
    if let Some(comparison) = &reports.comparison {
        say::line(comparison);
    }
    Ok(())
}
