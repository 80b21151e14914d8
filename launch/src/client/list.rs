//! `robocell list`.

use cell_model::runs::spec::RunSpec;
use cell_model::{Cell, Data};
use serde::Serialize;

use crate::cli::ListArgs;
use crate::failure::Failure;
use crate::rundir::RunDir;
use crate::say;

#[derive(Debug, Serialize)]
struct Demo {
    name: String,
    description: String,
    policies: Vec<String>,
    default_policy: String,
}

#[derive(Debug, Serialize)]
struct Running {
    cell: String,
    demo: Option<String>,
    pid: u32,
    since: String,
}

#[derive(Debug, Serialize)]
struct List {
    demos: Vec<Demo>,
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
        running: running(args.cell.as_deref()),
    };
    if args.json {
        say::line(serde_json::to_string(&list).map_err(Failure::configuration)?);
        return Ok(());
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
        let demo = cell.demo.as_deref().unwrap_or("starting");
        say::line(format_args!(
            "running: cell {} ({demo}), pid {}, since {}",
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

fn running(only: Option<&str>) -> Vec<Running> {
    let wanted = |name: &str| only.is_none_or(|only| only == name);
    let describe = |(cell, dir): (String, RunDir)| {
        let holder = dir.holder()?;
        let demo = RunSpec::load(&dir.spec()).ok().map(|spec| spec.demo);
        Some(Running {
            cell,
            demo,
            pid: holder.pid,
            since: holder.since,
        })
    };
    RunDir::all()
        .into_iter()
        .filter(|(name, _)| wanted(name))
        .filter_map(describe)
        .collect()
}
