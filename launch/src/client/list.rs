//! `robocell list`.

use std::path::PathBuf;

use cell_model::{Cell, Data};
use cell_run::spec::RunSpec;
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::Failure;
use supervisor::rundir::RunDir;

use crate::args::ListArgs;
use crate::{output, say};

/// A cell file.
#[derive(Debug, Serialize, JsonSchema)]
struct Demo {
    /// What `run` takes.
    name: String,
    /// One line.
    description: String,
    /// Policies of its task.
    policies: Vec<String>,
    /// The one without `--policy`.
    default_policy: String,
}

/// A cell or a replay that runs.
#[derive(Debug, Serialize, JsonSchema)]
struct Running {
    /// What `--cell` takes.
    cell: String,
    /// Name of the demo; none of a replay, and while the cell starts.
    demo: Option<String>,
    /// The recording that is replayed.
    #[schemars(with = "Option<String>")]
    recording: Option<PathBuf>,
    /// Process id of the launcher.
    pid: u32,
    /// Wall clock, UTC.
    since: String,
}

/// The result of `robocell list --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct List {
    /// By name.
    demos: Vec<Demo>,
    /// By name.
    running: Vec<Running>,
}

/// Prints the demos and the cells that run.
pub(crate) fn list(args: &ListArgs) -> Result<(), Failure> {
    let data = args
        .data
        .data
        .as_ref()
        .map_or_else(cell_files::data, Data::dir);
    let list = List {
        demos: demos(&data)?,
        running: running()?,
    };
    if args.json {
        return output::print(&list);
    }
    for demo in &list.demos {
        let policies = demo.policies.join(", ");
        say::line(format_args!(
            "{:<16} {} (policies: {policies})",
            demo.name, demo.description
        ));
    }
    if list.running.is_empty() {
        say::line("No cell is running.");
    }
    for cell in &list.running {
        let what = match (&cell.demo, &cell.recording) {
            (_, Some(recording)) => format!("replay of {}", recording.display()),
            (Some(demo), None) => demo.clone(),
            (None, None) => "starting".to_owned(),
        };
        say::line(format_args!(
            "running: cell `{}` ({what}), pid {}, since {}",
            cell.cell, cell.pid, cell.since
        ));
    }
    Ok(())
}

fn demos(data: &Data) -> Result<Vec<Demo>, Failure> {
    let mut demos = Vec::new();
    for (name, description) in data.demos() {
        let cell = Cell::load(data, &name, 0, None).map_err(Failure::configuration)?;
        demos.push(Demo {
            name,
            description,
            policies: cell.policies,
            default_policy: cell.default_policy,
        });
    }
    Ok(demos)
}

fn running() -> Result<Vec<Running>, Failure> {
    let describe = |(cell, dir): (String, RunDir)| {
        let holder = dir.holder()?;
        let demo = RunSpec::load(&dir.spec()).ok().map(|spec| spec.demo);
        Some(Running {
            cell,
            demo,
            recording: dir.recording(),
            pid: holder.pid,
            since: holder.since,
        })
    };
    let all = RunDir::all()?.into_iter();
    Ok(all.filter_map(describe).collect())
}
