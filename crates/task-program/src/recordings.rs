//! Recordings of episodes that did not end done, for `eval --record-failures`. An episode
//! depends on its seed alone, so it is run once more by the launcher, which records it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cell_rt::signal;
use evaluation::EvaluationError;
use evaluation::report::{Failed, episodes};
use serde::Deserialize;

/// Where recordings go, and how they are made.
pub(crate) struct Recordings<'a> {
    /// The folder.
    pub(crate) dir: &'a Path,
    /// The program of the launcher.
    pub(crate) launcher: &'a Path,
    /// Name of the demo, and of the policy.
    pub(crate) names: (&'a str, &'a str),
    /// See [`evaluation::info::Plan::arguments`].
    pub(crate) arguments: &'a [String],
}

/// Why a recording is missing.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RecordingError {
    /// The rows.
    #[error(transparent)]
    Rows(#[from] EvaluationError),
    /// The folder, or the launcher.
    #[error("cannot record failed episodes in {dir}: {source}", dir = dir.display())]
    Io {
        /// The folder.
        dir: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Of the summary that the launcher prints.
#[derive(Deserialize)]
struct Summary {
    state_hash: String,
}

impl Recordings<'_> {
    /// Records each failed episode of `rows` that has no recording yet; how many were made.
    /// What goes wrong with one of them is a warning.
    pub(crate) fn of(&self, rows: &Path) -> Result<u64, RecordingError> {
        let cannot = |source| RecordingError::Io {
            dir: self.dir.to_owned(),
            source,
        };
        fs::create_dir_all(self.dir).map_err(cannot)?;
        let mut made = 0;
        for failed in episodes(rows)?.failed {
            let name = match failed.key.variant {
                0 => format!("seed-{}", failed.key.seed),
                variant => format!("seed-{}-variant-{variant}", failed.key.seed),
            };
            let file = self.dir.join(format!("{name}.mcap"));
            // An episode that could not be finished has no end to record.
            if failed.state_hash.is_empty() || file.exists() {
                continue;
            }
            if signal::stop_requested() {
                break;
            }
            let partial = self.dir.join(format!("{name}.partial.mcap"));
            fs::remove_file(&partial).ok();
            match self.record(&failed, &partial).map_err(cannot)? {
                Ok(()) => {
                    fs::rename(&partial, &file).map_err(cannot)?;
                    made += 1;
                }
                Err(reason) if signal::stop_requested() => drop(reason),
                Err(reason) => {
                    cell_worker::warn(format_args!("{}: not recorded: {reason}", failed.key));
                }
            }
        }
        Ok(made)
    }

    /// Runs an episode once more.
    fn record(&self, failed: &Failed, file: &Path) -> io::Result<Result<(), String>> {
        let (demo, policy) = self.names;
        let seed = failed.key.seed.to_string();
        let set = failed.settings.iter();
        let set = set.flat_map(|one| ["--set".to_owned(), one.to_string()]);
        let cell = format!("eval-{}", std::process::id());
        let run = Command::new(self.launcher)
            .args(["run", demo, "--policy", policy, "--seed", &seed])
            .args(["--speed", "max", "--headless", "--until-done", "--json"])
            .args(["--cell", &cell, "--record"])
            .arg(file)
            .args(self.arguments)
            .args(set)
            .stdin(Stdio::null())
            .output()?;
        let text = String::from_utf8_lossy(&run.stdout);
        let summary = text.lines().last().map(serde_json::from_str::<Summary>);
        let Some(Ok(summary)) = summary else {
            let error = String::from_utf8_lossy(&run.stderr);
            let last = error.lines().last().unwrap_or("it said nothing");
            return Ok(Err(format!("the run ended with {}: {last}", run.status)));
        };
        if summary.state_hash != failed.state_hash {
            let (found, wanted) = (summary.state_hash, &failed.state_hash);
            return Ok(Err(format!(
                "its last state is {found}, of the row {wanted}"
            )));
        }
        Ok(Ok(()))
    }
}
