//! `robocell logs`.

use std::path::Path;
use std::time::Duration;

use cell_rt::stdout;
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Context, Failure};
use supervisor::process_log::Follower;
use supervisor::rundir::RunDir;

use crate::args::LogsArgs;
use crate::suggestion::did_you_mean;
use crate::{output, say};

/// A line of `robocell logs --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LogLine<'a> {
    /// The process that wrote it.
    process: &'a str,
    /// Without the end of the line.
    text: &'a str,
}

/// One log, and how far it was printed.
struct Tail {
    name: String,
    log: Follower,
    /// The beginning of a line whose end is not written yet.
    partial: Vec<u8>,
    json: bool,
}

impl Tail {
    /// Prints the lines that are new; at the end of all also one that has no end.
    fn print(&mut self, is_last: bool) -> Result<(), Failure> {
        let what = format!("read the log of {}", self.name);
        self.log.read(&mut self.partial).cannot(what)?;
        if is_last && !self.partial.ends_with(b"\n") && !self.partial.is_empty() {
            self.partial.push(b'\n');
        }
        // Only whole lines are decoded: a read may end inside a character.
        let end = self.partial.iter().rposition(|byte| *byte == b'\n');
        let lines: Vec<u8> = self.partial.drain(..end.map_or(0, |end| end + 1)).collect();
        for text in String::from_utf8_lossy(&lines).lines() {
            let process = self.name.as_str();
            if self.json {
                output::print(&LogLine { process, text })?;
            } else {
                say::line(format_args!("{process:<14} {text}"));
            }
        }
        Ok(())
    }
}

/// Prints the logs of a cell that runs or has run.
pub(crate) fn logs(args: &LogsArgs) -> Result<(), Failure> {
    let dir = RunDir::of(&args.cell.cell)?;
    let names = names(&dir.logs());
    if names.is_empty() {
        // Its error tells a directory that cannot be read from a cell that does not run.
        dir.running(&args.cell.cell)?;
        return Err(Failure::not_running(&args.cell.cell));
    }
    let wanted = match &args.process {
        None => names.clone(),
        Some(word) => matching(&names, word)?,
    };
    let tail = |name: String| {
        let log = Follower::open(&dir.log(&name)).cannot(format!("open the log of {name}"))?;
        Ok(Tail {
            name,
            log,
            partial: Vec::new(),
            json: args.json,
        })
    };
    let mut tails = wanted
        .into_iter()
        .map(tail)
        .collect::<Result<Vec<_>, Failure>>()?;
    loop {
        // Before the logs are read: what a cell wrote at its end is read, too.
        let is_last = !args.follow || dir.holder().is_none();
        for tail in &mut tails {
            tail.print(is_last)?;
        }
        if is_last || !stdout::has_reader() {
            return Ok(());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn matching(names: &[String], word: &str) -> Result<Vec<String>, Failure> {
    let means =
        |name: &&String| *name == word || (word == "controller" && name.starts_with("controller-"));
    let found: Vec<String> = names.iter().filter(means).cloned().collect();
    if found.is_empty() {
        let near = did_you_mean(word, names);
        return Err(Failure::usage(format!(
            "process `{word}` is unknown{near}; there are {}",
            names.join(", ")
        )));
    }
    Ok(found)
}

fn names(logs: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(logs).into_iter().flatten().flatten();
    let name = |path: std::path::PathBuf| {
        path.extension()
            .is_some_and(|e| e == "log")
            .then(|| path.file_stem()?.to_str().map(str::to_owned))
            .flatten()
    };
    let mut names: Vec<String> = entries.filter_map(|entry| name(entry.path())).collect();
    names.sort();
    names
}
