//! `robocell logs`.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use schemars::JsonSchema;
use serde::Serialize;

use crate::cli::LogsArgs;
use crate::failure::{Context, Failure};
use crate::run::plan::did_you_mean;
use crate::rundir::RunDir;

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
    file: File,
    json: bool,
}

impl Tail {
    /// Prints what is new, each line with the name of the process.
    fn print(&mut self, partial: &mut String) -> io::Result<bool> {
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes)?;
        partial.push_str(&String::from_utf8_lossy(&bytes));
        let mut out = io::stdout().lock();
        while let Some(end) = partial.find('\n') {
            let line: String = partial.drain(..=end).collect();
            let (process, text) = (self.name.as_str(), line.trim_end_matches('\n'));
            if self.json {
                serde_json::to_writer(&mut out, &LogLine { process, text })?;
                writeln!(out)?;
            } else {
                writeln!(out, "{process:<14} {text}")?;
            }
        }
        out.flush()?;
        Ok(!bytes.is_empty())
    }
}

/// Prints the logs of a cell that runs or has run.
pub(crate) fn logs(args: &LogsArgs) -> Result<(), Failure> {
    let dir = RunDir::of(&args.cell.cell);
    let names = names(&dir.logs());
    if names.is_empty() {
        return Err(Failure::not_running(&args.cell.cell));
    }
    let wanted = match &args.process {
        None => names.clone(),
        Some(word) => matching(&names, word)?,
    };
    let mut tails = Vec::new();
    for name in wanted {
        let file = File::open(dir.log(&name)).cannot(format!("open the log of {name}"))?;
        let json = args.json;
        tails.push((Tail { name, file, json }, String::new()));
    }
    loop {
        for (tail, partial) in &mut tails {
            if tail.print(partial).is_err() {
                // The reader has closed the pipe.
                return Ok(());
            }
        }
        if !args.follow || dir.holder().is_none() {
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
