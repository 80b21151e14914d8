//! `robocell break`: pauses the cell when the task reaches a node, state or guard.

use std::time::{Duration, Instant};

use ipc_types::BreakName;
use ipc_types::operator::OperatorAction;
use serde_json::json;

use super::Session;
use super::follow::Follower;
use super::operate::{ask_physics, request};
use super::top::View;
use super::watched::Trace;
use crate::cli::BreakArgs;
use crate::failure::Failure;
use crate::run::plan::did_you_mean;
use crate::say;

/// The task sends its pictures once a second.
const PICTURES: Duration = Duration::from_millis(1500);
/// Time between two looks.
const LOOK: Duration = Duration::from_millis(20);

/// `robocell break [NAME] [--remove]`.
pub(crate) fn breakpoint(args: &BreakArgs) -> Result<(), Failure> {
    match &args.name {
        Some(name) => change(args, name),
        None => list(args),
    }
}

fn change(args: &BreakArgs, name: &str) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Break);
    wish.name = BreakName::new(name);
    wish.count = u32::from(!args.remove);
    if wish.name.as_str() != name || name.is_empty() {
        return Err(Failure::usage(format!(
            "`{name}` is no name of a node, state or guard: it has 1 to 48 bytes"
        )));
    }
    let session = if args.remove {
        Session::of(&args.cell.cell)?
    } else {
        known(args, name)?
    };
    ask_physics(&session.join()?, &wish)?;
    if args.remove {
        say::line(format_args!("breakpoint {name} removed"));
    } else {
        say::line(format_args!(
            "the cell pauses when the task reaches {name}; `robocell resume` continues"
        ));
    }
    Ok(())
}

/// The cell, once its task is known to have `name`.
fn known(args: &BreakArgs, name: &str) -> Result<Session, Failure> {
    let mut view = View::open(&args.cell.cell)?;
    let until = Instant::now() + PICTURES;
    while !view.trace.is_complete() && Instant::now() < until {
        std::thread::sleep(LOOK);
        view.update();
    }
    let names = names(&view.trace);
    if names.is_empty() || names.iter().any(|known| known == name) {
        return Ok(view.session);
    }
    let near = did_you_mean(name, &names);
    Err(Failure::configuration(format!(
        "the task has no node, state or guard `{name}`{near}; it has {}",
        names.join(", ")
    )))
}

/// Names and ids of nodes and states, and guards of edges.
fn names(trace: &Trace) -> Vec<String> {
    let mut names = Vec::new();
    for picture in &trace.pictures {
        for node in &picture.graph.nodes {
            names.extend([node.name.clone(), node.id.clone()]);
        }
        let labels = picture.graph.edges.iter().map(|edge| edge.label.as_str());
        names.extend(labels.flat_map(guards));
    }
    names.retain(|name| !name.is_empty());
    names.sort();
    names.dedup();
    names
}

/// Guards of a label, `trigger [one, not other]`.
fn guards(label: &str) -> Vec<String> {
    let guards = label.split_once(" [").map_or("", |(_, guards)| guards);
    let guards = guards.split(']').next().unwrap_or_default();
    let names = guards
        .split(", ")
        .map(|guard| guard.strip_prefix("not ").unwrap_or(guard));
    names.map(str::to_owned).collect()
}

fn list(args: &BreakArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let state = Follower::new(&session, &session.join()?)?.now()?;
    let names: Vec<&str> = state.panel.breaks().iter().map(BreakName::as_str).collect();
    if args.json {
        say::line(json!({ "breakpoints": names }));
    } else if names.is_empty() {
        say::line("no breakpoints; `robocell break NAME` sets one");
    } else {
        names.iter().for_each(say::line);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::guards;

    #[test]
    fn guards_of_a_label_are_named_without_their_sign() {
        assert_eq!(guards("tick [near, not held]"), ["near", "held"]);
        assert_eq!(guards("tick"), [""]);
    }
}
