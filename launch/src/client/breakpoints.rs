//! `robocell break`: pauses the cell when the task reaches a node, state or guard.

use std::time::{Duration, Instant};

use cell_model::runs::phase_name;
use ipc_types::BreakName;
use ipc_types::operator::OperatorAction;
use serde_json::json;
use supervisor::failure::Failure;

use super::follow::Follower;
use super::operate::{ask_physics, request};
use super::session::Session;
use super::top::View;
use super::watched::Trace;
use crate::args::BreakArgs;
use crate::say;
use crate::suggestion::did_you_mean;

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
    // `BreakName` cuts a name that is too long, and no node has the cut one.
    if wish.name.as_str() != name || name.is_empty() {
        return Err(Failure::usage(format!(
            "`{name}` cannot be the name of a node, state or guard: a name has 1 to 48 bytes"
        )));
    }
    // A removal is not checked: the policy that had the node may have been replaced since.
    let session = if args.remove {
        Session::of(&args.cell.cell)?
    } else {
        let (session, spelled) = known(args, name)?;
        wish.name = BreakName::new(&spelled);
        session
    };
    let name = wish.name.as_str();
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

/// The cell, once its task is known to have `name`, and the name as the task spells it.
fn known(args: &BreakArgs, name: &str) -> Result<(Session, String), Failure> {
    let mut view = View::open(&args.cell.cell)?;
    let until = Instant::now() + PICTURES;
    while !view.trace.is_complete() && Instant::now() < until {
        std::thread::sleep(LOOK);
        view.update();
    }
    let names = names(&view.trace);
    // No picture has come, as from a task that is being restarted: the name cannot be checked.
    if names.is_empty() {
        return Ok((view.session, name.to_owned()));
    }
    if let Some(spelled) = spelled(&names, name) {
        return Ok((view.session, spelled.clone()));
    }
    let arms = view.session.load_cell().map(|cell| cell.arms);
    let arms: Vec<String> = arms.into_iter().flatten().map(|arm| arm.name).collect();
    if let Some(spelled) = with_arm(&names, name, &arms) {
        return Ok((view.session, spelled));
    }
    let near = did_you_mean(name, &names);
    Err(Failure::configuration(format!(
        "the task has no node, state or guard `{name}`{near}; it has {}",
        names.join(", ")
    )))
}

/// The one of `names` that is `name`, or is when both are written as phases: a phase `LIFT`
/// is shown while a tree's node is `Lift`, and `BRING_RED_1` while it is `bring[red_1]`.
fn spelled<'a>(names: &'a [String], name: &str) -> Option<&'a String> {
    let exact = names.iter().find(|known| *known == name);
    exact.or_else(|| {
        let mut alike = names
            .iter()
            .filter(|known| phase_name::alike(&[name], &[known]));
        // Between two such names it would be a guess which one is meant.
        alike.next().filter(|_| alike.next().is_none())
    })
}

/// As [`spelled`], of a name with that of an arm in front: with a single arm the node's own
/// name, with several the phase of the node of that arm.
fn with_arm(names: &[String], name: &str, arms: &[String]) -> Option<String> {
    let pairs = arms
        .iter()
        .flat_map(|arm| names.iter().map(move |known| (arm, known)));
    let mut found = pairs.filter(|(arm, known)| phase_name::alike(&[name], &[arm, known]));
    let (arm, known) = found.next()?;
    Some(match arms {
        [_] => known.clone(),
        _ => phase_name::of_arm(arm, known),
    })
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
    use super::{guards, spelled, with_arm};

    #[test]
    fn a_name_is_found_in_another_case_when_only_one_is_like_it() {
        let names = ["Lift", "held", "Held"].map(str::to_owned);
        let found = |name| spelled(&names, name).map(String::as_str);
        assert_eq!(found("LIFT"), Some("Lift"));
        assert_eq!(found("Held"), Some("Held"));
        assert_eq!(found("HELD"), None, "two are like it");
        assert_eq!(found("place"), None);
    }

    #[test]
    fn a_phase_is_the_name_of_a_node_with_that_of_its_arm() {
        let names = ["bring[red_1]", "bring[red_2]"].map(str::to_owned);
        let found = |name| spelled(&names, name).map(String::as_str);
        assert_eq!(found("BRING_RED_1"), Some("bring[red_1]"));
        let arms = ["left", "right"].map(str::to_owned);
        let of = |name, arms| with_arm(&names, name, arms);
        let phase = "RIGHT_BRING_RED_2";
        assert_eq!(of(phase, &arms).as_deref(), Some(phase));
        assert_eq!(of(phase, &arms[1..]).as_deref(), Some("bring[red_2]"));
        assert_eq!(of(phase, &arms[..1]), None);
    }

    #[test]
    fn guards_of_a_label_are_named_without_their_sign() {
        assert_eq!(guards("tick [near, not held]"), ["near", "held"]);
        assert_eq!(guards("tick"), [""]);
    }
}
