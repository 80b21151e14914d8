//! `robocell man`: the manual, a page for each command.

use std::path::Path;

use clap::{Command, CommandFactory};
use supervisor::failure::{Context, Failure};

use crate::args::{Cli, ManArgs};
use crate::say;
use crate::suggestion::did_you_mean;

/// Prints the page of a command, or writes all pages into a folder.
pub(crate) fn man(args: &ManArgs) -> Result<(), Failure> {
    // `help` needs no page of its own: every command has `--help`.
    let mut root = Cli::command().disable_help_subcommand(true);
    // It sets the full names, as `robocell-bt-show`, by which the files are named.
    root.build();
    if let Some(dir) = &args.dir {
        std::fs::create_dir_all(dir).cannot(format!("make {}", dir.display()))?;
        let count = write_all(&root, dir)?;
        say::line(format_args!("{count} pages in {}", dir.display()));
        return Ok(());
    }
    let mut command = &root;
    for word in &args.command {
        let found = visible(command).find(|inner| inner.get_name() == word);
        command = found.ok_or_else(|| unknown(command, word))?;
    }
    say::raw(&page(command)?);
    Ok(())
}

fn visible(command: &Command) -> impl Iterator<Item = &Command> {
    let all = command.get_subcommands();
    all.filter(|command| !command.is_hide_set())
}

fn unknown(command: &Command, word: &str) -> Failure {
    let names: Vec<String> = visible(command).map(|c| c.get_name().to_owned()).collect();
    let near = did_you_mean(word, &names);
    Failure::usage(format!("no manual page of `{word}`{near}"))
}

fn page(command: &Command) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    let manual = clap_mangen::Man::new(command.clone());
    manual.render(&mut page).cannot("print the manual page")?;
    Ok(page)
}

/// Writes the page of `command` and of all below it; how many these are.
fn write_all(command: &Command, dir: &Path) -> Result<usize, Failure> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let path = dir.join(format!("{name}.1"));
    std::fs::write(&path, page(command)?).cannot(format!("write {}", path.display()))?;
    let mut count = 1;
    for inner in visible(command) {
        count += write_all(inner, dir)?;
    }
    Ok(count)
}
