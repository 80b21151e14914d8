//! Completions: the scripts for shells, and the names they ask for.

use clap::CommandFactory;
use clap_complete::Shell;
use ipc_types::topic::Process;
use supervisor::failure::Failure;
use supervisor::rundir::{DEFAULT_CELL, RunDir};

use crate::args::kinds::NameKind;
use crate::args::{Cli, CompleteArgs};
use crate::client::Session;
use crate::{say, task_program};

/// Prints the script for `shell`.
pub(crate) fn script(shell: Shell) {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "robocell", &mut text);
    let text = String::from_utf8_lossy(&text).into_owned();
    let text = match shell {
        Shell::Bash => text + include_str!("names.bash"),
        Shell::Fish => text + include_str!("names.fish"),
        Shell::Zsh => zsh(&text),
        _ => text,
    };
    say::raw(text.as_bytes());
}

/// Arguments that name something ask for the names.
fn zsh(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let kind = [
            ("':demo ", "demos"),
            ("'--demo=", "demos"),
            ("'::what ", "demos"),
            ("'--policy=", "policies"),
            ("':object ", "objects"),
            ("'--cell=", "cells"),
        ];
        let line_start = line.trim_start();
        let kind = kind.iter().find(|(start, _)| line_start.starts_with(start));
        match kind {
            Some((_, kind)) => {
                out.push_str(&line.replace(":_default'", &format!(":_robocell_{kind}'")));
            }
            None => out.push_str(line),
        }
        out.push('\n');
        // At the top: the last lines of the script may call the functions at once.
        if line == "autoload -U is-at-least" {
            out.push_str(include_str!("names.zsh"));
        }
    }
    out
}

/// Prints the names of a kind, one a line; none where they cannot be had.
pub(crate) fn names(args: &CompleteArgs) {
    let words = Words::of(&args.words);
    // Errors are dropped: a completion has no place to show them.
    let names = match args.kind {
        NameKind::Demos => demos(),
        NameKind::Policies => policies(&words).unwrap_or_default(),
        NameKind::Objects => objects(&words).unwrap_or_default(),
        NameKind::Nodes => nodes(&words).unwrap_or_default(),
        NameKind::Cells => cells(),
        NameKind::Processes => processes(&words).unwrap_or_default(),
    };
    names.iter().for_each(say::line);
}

/// The incomplete command line.
struct Words<'a> {
    all: &'a [String],
    cell: &'a str,
}

impl<'a> Words<'a> {
    fn of(all: &'a [String]) -> Self {
        // Not by clap, which refuses a line that is not complete.
        let option = all.iter().position(|word| word == "--cell");
        let value = option.and_then(|at| all.get(at + 1));
        let joined = all.iter().find_map(|word| word.strip_prefix("--cell="));
        let cell = joined.or(value.map(String::as_str));
        Self {
            all,
            cell: cell.unwrap_or(DEFAULT_CELL),
        }
    }
}

fn demos() -> Vec<String> {
    let demos = cell_files::data().demos();
    demos.into_iter().map(|(name, _)| name).collect()
}

fn policies(words: &Words<'_>) -> Result<Vec<String>, Failure> {
    let demos = demos();
    if let Some(demo) = words.all.iter().find(|word| demos.contains(word)) {
        return Ok(crate::run::plan::cell::load(None, demo, 0, None, &[])?.policies);
    }
    Ok(Session::of(words.cell)?.load_cell()?.policies)
}

fn objects(words: &Words<'_>) -> Result<Vec<String>, Failure> {
    let cell = Session::of(words.cell)?.load_cell()?;
    Ok(cell.objects.into_iter().map(|object| object.name).collect())
}

fn nodes(words: &Words<'_>) -> Result<Vec<String>, Failure> {
    let spec = Session::of(words.cell)?.spec;
    let program = spec.task_program.as_deref();
    task_program::node_names(program, &spec.demo, &spec.policy, spec.data_dir.as_deref())
}

fn cells() -> Vec<String> {
    let running = RunDir::all().unwrap_or_default().into_iter();
    let running = running.filter(|(_, dir)| dir.holder().is_some());
    running.map(|(name, _)| name).collect()
}

fn processes(words: &Words<'_>) -> Result<Vec<String>, Failure> {
    let arms = Session::of(words.cell)?.spec.arms;
    let all = Process::all(arms).into_iter();
    Ok(all.map(Process::name).collect())
}
