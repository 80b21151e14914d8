//! `robocell bt` and `fsm`: what a policy is made of, and how it runs.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Duration;

use cell_rt::stdout;
use supervisor::failure::{Context, Failure};

use super::columns::terminal_width;
use super::import;
use super::top::View;
use crate::args::{BehaviourVerb, CheckArgs, DataArgs, ShowArgs, TreeArgs, TreeVerb};
use crate::client::session::Session;
use crate::run::plan;
use crate::{say, task_program};

/// How often a running behaviour is looked at.
const LOOK: Duration = Duration::from_millis(100);
/// Looks for pictures, which the task sends once a second: without one after this many looks
/// (3 s) it has none.
const LOOKS_FOR_PICTURES: usize = 30;
/// Marks a running node in a picture.
const RUNS: &str = " *";
/// Clears a terminal.
const CLEAR: &str = "\x1b[2J\x1b[H";

/// Shows, checks or imports a tree.
pub(crate) fn tree(args: &TreeArgs) -> Result<(), Failure> {
    match &args.verb {
        TreeVerb::Behaviour(verb) => behaviour("bt", verb),
        TreeVerb::Import(import) => import::import(import),
    }
}

/// Shows or checks a behaviour; `kind` is `bt` or `fsm`.
pub(crate) fn behaviour(kind: &str, verb: &BehaviourVerb) -> Result<(), Failure> {
    match verb {
        BehaviourVerb::Show(show) if show.live => live(show),
        BehaviourVerb::Show(show) => draw(kind, show),
        BehaviourVerb::Check(check) => checked(kind, check),
    }
}

fn checked(kind: &str, args: &CheckArgs) -> Result<(), Failure> {
    let file = args.file.display().to_string();
    let program = found(args.program.task.as_deref())?;
    let mut arguments = vec!["behaviour", "check", kind, &file];
    arguments.extend(args.json.then_some("--json"));
    let question = format!("a check of {file}");
    task_program::answer(program.as_deref(), &question, &arguments)
}

fn draw(kind: &str, args: &ShowArgs) -> Result<(), Failure> {
    let (what, policy, program, dir) = if let Some(what) = &args.what {
        (
            what.clone(),
            args.policy.clone(),
            program_of(what, &args.data)?,
            args.data.data.clone(),
        )
    } else {
        let spec = Session::of(&args.cell.cell)?.spec;
        let policy = args.policy.clone().unwrap_or(spec.policy);
        let dir = args.data.data.clone().or(spec.data_dir);
        (spec.demo, Some(policy), spec.task_program, dir)
    };
    let mut arguments: Vec<String> = ["behaviour", "show", kind, &what, "--format"]
        .map(str::to_owned)
        .to_vec();
    arguments.push(args.format.word().to_owned());
    if let Some(policy) = policy {
        arguments.extend(["--policy".to_owned(), policy]);
    }
    if let Some(dir) = &dir {
        let dir = std::fs::canonicalize(dir).cannot(format!("find {}", dir.display()))?;
        arguments.extend(["--data".to_owned(), dir.display().to_string()]);
    }
    // A file or a pipe has no width at which lines are cut.
    if std::io::stdout().is_terminal() {
        arguments.extend(["--width".to_owned(), terminal_width().to_string()]);
    }
    let question = format!("a picture of {what}");
    task_program::answer(program.as_deref(), &question, &arguments)
}

/// The task program asked for; `None` for the built-in one.
fn found(asked: Option<&str>) -> Result<Option<PathBuf>, Failure> {
    asked.map(|name| task_program::find(name, None)).transpose()
}

/// The task program that knows `what`, a demo or a file.
fn program_of(what: &str, args: &DataArgs) -> Result<Option<PathBuf>, Failure> {
    let data = args.data.as_deref();
    match plan::cell::load(data, what, 0, None, &[]) {
        Ok(cell) => task_program::of_cell(args.program.task.as_deref(), &cell, data),
        // A file, or a name that the task program refuses with advice.
        Err(_) => found(args.program.task.as_deref()),
    }
}

/// Prints the behaviour of a running cell whenever a node of it changes.
fn live(args: &ShowArgs) -> Result<(), Failure> {
    let mut view = View::open(&args.cell.cell)?;
    let in_place = std::io::stdout().is_terminal();
    let mut shown = String::new();
    for looks in 0_usize.. {
        view.update();
        // Statuses are sent ten times a second, but not by a task that never worked.
        let waits = !view.trace.has_statuses() && looks < LOOKS_FOR_PICTURES;
        let frame = if waits {
            String::new()
        } else {
            frame(&view, args)?
        };
        if !frame.is_empty() && frame != shown {
            if in_place {
                say::raw(CLEAR.as_bytes());
            }
            say::line(if in_place {
                on_screen(&frame)
            } else {
                frame.clone()
            });
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
        // A reader that ended reads no later frame, of which there may be none for hours.
        if view.session.dir.holder().is_none() || !stdout::has_reader() {
            break;
        }
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// The part of `frame` that fits a terminal: the lines around a running node.
fn on_screen(frame: &str) -> String {
    let rows = crossterm::terminal::size().map_or(usize::MAX, |(_, rows)| usize::from(rows));
    // One row less: the newline after the frame scrolls by one.
    around_active(frame, rows.saturating_sub(1).max(3))
}

/// `rows` lines of `frame`, with the last one that runs in their middle.
fn around_active(frame: &str, rows: usize) -> String {
    let lines: Vec<&str> = frame.lines().collect();
    if lines.len() <= rows {
        return frame.to_owned();
    }
    let runs = lines.iter().rposition(|line| line.contains(RUNS));
    let middle = runs.unwrap_or(0);
    // Two rows are for the counts of the lines left out.
    let kept = rows - 2;
    let from = middle.saturating_sub(kept / 2).min(lines.len() - kept);
    let shown = lines[from..from + kept].join("\n");
    let below = lines.len() - kept - from;
    format!("({from} lines above)\n{shown}\n({below} lines below)")
}

/// The pictures without their ports, which do not change; nothing before all of
/// them were heard.
fn frame(view: &View, args: &ShowArgs) -> Result<String, Failure> {
    if !view.trace.is_complete() {
        return Ok(String::new());
    }
    let pictures = &view.trace.pictures;
    if let Some(arm) = &args.arm
        && !pictures.iter().any(|picture| picture.graph.name == *arm)
    {
        let names: Vec<&str> = pictures.iter().map(|p| p.graph.name.as_str()).collect();
        return Err(Failure::configuration(format!(
            "--arm {arm}: this policy has no such picture; it has {}",
            names.join(", ")
        )));
    }
    let wanted = |name: &str| args.arm.as_deref().is_none_or(|arm| arm == name);
    let mut drawn = Vec::new();
    for picture in pictures.iter().filter(|p| wanted(&p.graph.name)) {
        let mut graph = picture.graph.clone();
        let statuses = Some(&picture.statuses[..]);
        let text = if picture.is_matrix() {
            behavior::views::matrix(&graph, statuses, terminal_width())
        } else {
            graph.nodes.iter_mut().for_each(|n| n.detail.clear());
            behavior::views::text(&graph, statuses)
        };
        drawn.push(format!("{}:\n{text}", graph.name));
    }
    Ok(drawn.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::around_active;

    #[test]
    fn a_picture_higher_than_the_screen_shows_what_runs() {
        let lines: Vec<String> = (0..60)
            .map(|n| format!("node {n}{}", if n == 41 { " *" } else { "" }))
            .collect();
        let shown = around_active(&lines.join("\n"), 12);
        assert_eq!(shown.lines().count(), 12);
        assert!(shown.contains("node 41 *"), "{shown}");
        assert!(shown.starts_with("(36 lines above)") && shown.ends_with("(14 lines below)"));
        assert_eq!(around_active("a\nb", 12), "a\nb");
    }
}
