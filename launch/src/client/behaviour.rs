//! `robocell bt`, `fsm` and `schema`: what a policy is made of, and how it runs.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;
use std::time::Duration;

use super::top::View;
use crate::cli::{BehaviourArgs, BehaviourVerb, CheckArgs, DataArgs, SchemaArgs, ShowArgs};
use crate::client::Session;
use crate::failure::{Context, Failure};
use crate::run::plan;
use crate::{say, task_program};

/// How often a running behaviour is looked at.
const LOOK: Duration = Duration::from_millis(100);
/// The pictures are sent once a second; who has not heard one after this long
/// will not.
const LOOKS_FOR_PICTURES: usize = 30;
/// Clears a terminal.
const CLEAR: &str = "\x1b[2J\x1b[H";

/// Shows or checks a behaviour; `kind` is `bt` or `fsm`.
pub(crate) fn behaviour(kind: &str, args: &BehaviourArgs) -> Result<(), Failure> {
    match &args.verb {
        BehaviourVerb::Show(show) if show.live => live(show),
        BehaviourVerb::Show(show) => draw(kind, show),
        BehaviourVerb::Check(check) => checked(kind, check),
    }
}

/// Prints the JSON Schema of a kind of file.
pub(crate) fn schema(args: &SchemaArgs) -> Result<(), Failure> {
    let program = found(args.task.as_deref())?;
    task_program::run(program.as_deref(), &["schema", args.what.word()])
}

fn checked(kind: &str, args: &CheckArgs) -> Result<(), Failure> {
    let file = args.file.display().to_string();
    let program = found(args.task.as_deref())?;
    task_program::run(program.as_deref(), &["behaviour", "check", kind, &file])
}

fn draw(kind: &str, args: &ShowArgs) -> Result<(), Failure> {
    let (what, policy, program) = if let Some(what) = &args.what {
        (
            what.clone(),
            args.policy.clone(),
            program_of(what, &args.data)?,
        )
    } else {
        let spec = Session::of(&args.cell.cell)?.spec;
        (spec.demo, Some(spec.policy), spec.task_program)
    };
    let mut arguments: Vec<String> = ["behaviour", "show", kind, &what, "--format"]
        .map(str::to_owned)
        .to_vec();
    arguments.push(args.format.word().to_owned());
    if let Some(policy) = policy {
        arguments.extend(["--policy".to_owned(), policy]);
    }
    if let Some(dir) = &args.data.data {
        let dir = std::fs::canonicalize(dir).cannot(format!("find {}", dir.display()))?;
        arguments.extend(["--data".to_owned(), dir.display().to_string()]);
    }
    task_program::run(program.as_deref(), &arguments)
}

/// The task program asked for; `None` for the built-in one.
fn found(asked: Option<&str>) -> Result<Option<PathBuf>, Failure> {
    asked.map(|name| task_program::find(name, None)).transpose()
}

/// The task program that knows `what`, a demo or a file.
fn program_of(what: &str, args: &DataArgs) -> Result<Option<PathBuf>, Failure> {
    let data = args.data.as_deref();
    match plan::load(data, what, 0, None) {
        Ok(cell) => task_program::of_cell(args.task.as_deref(), &cell, data),
        // A file, or a name that the task program refuses with advice.
        Err(_) => found(args.task.as_deref()),
    }
}

/// Prints the behaviour of a running cell whenever a node of it changes.
fn live(args: &ShowArgs) -> Result<(), Failure> {
    let mut view = View::open(&args.cell.cell)?;
    let in_place = std::io::stdout().is_terminal();
    let mut shown = String::new();
    for looks in 0_usize.. {
        view.update();
        let frame = frame(&view);
        if !frame.is_empty() && frame != shown {
            if in_place {
                write!(std::io::stdout(), "{CLEAR}").ok();
            }
            say::line(&frame);
            shown = frame;
            if args.once {
                return Ok(());
            }
        }
        if shown.is_empty() && looks == LOOKS_FOR_PICTURES {
            let silent = "the task sent no picture of its policy: one in if/else has none, and a task that \
                 is gone sends none, see `robocell status`";
            if args.once {
                return Err(Failure::configuration(silent));
            }
            say::warn(silent);
        }
        if view.session.dir.holder().is_none() {
            break;
        }
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// The pictures without their ports, which do not change; nothing before all of
/// them were heard.
fn frame(view: &View) -> String {
    if !view.trace.is_complete() {
        return String::new();
    }
    let mut drawn = Vec::new();
    for picture in &view.trace.pictures {
        let mut graph = picture.graph.clone();
        graph.nodes.iter_mut().for_each(|n| n.detail.clear());
        let text = behavior::views::text(&graph, Some(&picture.statuses));
        drawn.push(format!("{}:\n{text}", graph.name));
    }
    drawn.join("\n")
}
