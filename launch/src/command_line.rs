//! The command line as clap gets it: one layout of help, switches that may be repeated, and
//! `--cell` at any place.

use std::ffi::OsString;

use clap::builder::StyledStr;
use clap::{Arg, ArgAction, Command, CommandFactory as _};

use crate::args::Cli;

/// All commands.
pub(crate) fn command() -> Command {
    plain(Cli::command())
}

fn plain(command: Command) -> Command {
    let explained: Vec<String> = command.get_arguments().filter_map(explanation).collect();
    let command = command.mut_args(plain_arg).mut_subcommands(plain);
    if explained.is_empty() {
        return command;
    }
    let written = command.get_after_help().map(StyledStr::to_string);
    let blocks: Vec<String> = explained.into_iter().chain(written).collect();
    command.after_help(blocks.join("\n\n"))
}

fn plain_arg(arg: Arg) -> Arg {
    if matches!(arg.get_action(), ArgAction::SetTrue) {
        // A script that adds a switch to a line need not know whether it is there.
        let id = arg.get_id().clone();
        return arg.overrides_with(id);
    }
    // Values with explanations between the options make clap choose another layout.
    let is_explained = explanation(&arg).is_some();
    arg.hide_possible_values(is_explained)
}

/// The values of `arg`, where they have explanations.
fn explanation(arg: &Arg) -> Option<String> {
    let values = arg.get_possible_values();
    let shown: Vec<(&str, String)> = values
        .iter()
        .filter(|value| !value.is_hide_set())
        .map(|value| {
            let help = value.get_help().map(StyledStr::to_string);
            (value.get_name(), help.unwrap_or_default())
        })
        .collect();
    if arg.is_hide_set() || shown.iter().all(|(_, help)| help.is_empty()) {
        return None;
    }
    let width = shown.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let line = |(name, help): &(&str, String)| format!("  {name:<width$}  {help}");
    let lines: Vec<String> = shown.iter().map(line).collect();
    let name = match arg.get_long() {
        Some(long) => format!("--{long}"),
        None => format!("<{}>", arg.get_id().as_str().to_uppercase()),
    };
    Some(format!("Values of {name}:\n{}", lines.join("\n")))
}

/// `words` with each `--cell NAME` at the end: it belongs to the last command of the line,
/// wherever it is typed.
pub(crate) fn cell_last(words: &[OsString]) -> Vec<OsString> {
    // A line that a shell completes is kept as it is.
    if words.get(1).is_some_and(|word| word == "complete") {
        return words.to_vec();
    }
    // Words after `--` are values, even if they look like options.
    let end = words.iter().position(|word| word == "--");
    let (line, rest) = words.split_at(end.unwrap_or(words.len()));
    let (mut others, mut cells) = (Vec::new(), Vec::new());
    let mut line = line.iter().cloned();
    while let Some(word) = line.next() {
        if word == "--cell" {
            cells.push(word);
            cells.extend(line.next());
        } else if word.to_string_lossy().starts_with("--cell=") {
            cells.push(word);
        } else {
            others.push(word);
        }
    }
    others
        .into_iter()
        .chain(cells)
        .chain(rest.iter().cloned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches as _;

    fn parsed(line: &str) -> Result<Cli, clap::Error> {
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let matches = command().try_get_matches_from(cell_last(&words))?;
        Cli::from_arg_matches(&matches)
    }

    #[test]
    fn the_cell_may_be_named_at_any_place() {
        for line in [
            "robocell --cell left record last 5s a.mcap",
            "robocell record --cell left last 5s a.mcap",
            "robocell record last 5s a.mcap --cell left",
            "robocell record last --cell=left 5s a.mcap",
            "robocell --cell left bt show",
            "robocell status --cell left --json",
        ] {
            let cli = format!(
                "{:?}",
                parsed(line).unwrap_or_else(|e| panic!("{line}: {e}"))
            );
            assert!(cli.contains("cell: \"left\""), "{line}: {cli}");
        }
        assert!(parsed("robocell list --cell left").is_err());
        assert!(parsed("robocell status --cell").is_err());
    }

    #[test]
    fn a_switch_may_be_repeated_and_a_value_may_not_be_contradicted() {
        assert!(parsed("robocell status --json --json").is_ok());
        assert!(parsed("robocell run reach --headless --headless").is_ok());
        assert!(parsed("robocell status --cell a --cell b").is_err());
        assert!(parsed("robocell run reach --seed 1 --seed 2").is_err());
    }

    #[test]
    fn all_commands_have_one_layout_of_help() {
        fn help(line: &str) -> String {
            parsed(line).unwrap_err().to_string()
        }
        fn check(command: &Command, line: &str) {
            let (short, long) = (format!("{line} -h"), format!("{line} --help"));
            assert_eq!(help(&short), help(&long), "{line}");
            for inner in command.get_subcommands() {
                check(inner, &format!("{line} {}", inner.get_name()));
            }
        }
        check(&command(), "robocell");
        let bench = help("robocell bench --help");
        assert!(bench.contains("  e2e      Age of the state"), "{bench}");
    }
}
