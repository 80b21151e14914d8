//! Recordings of episodes that did not end done, for `eval --record-failures`. An episode
//! depends on its seed alone, so it is run once more by the launcher, which records it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cell_model::draft::Draft;
use cell_rt::signal;
use cell_sim::episodes::{episode_name, recording_name};
use evaluation::EvaluationError;
use evaluation::report::{Failed, episodes};
use serde::Deserialize;

/// The folder of the recordings, and how they are made.
pub(crate) struct Recordings<'a> {
    /// The folder.
    pub(crate) dir: &'a Path,
    /// The program of the launcher.
    pub(crate) launcher: &'a Path,
    /// Directory with the answers of a policy server.
    pub(crate) answers: Option<&'a Path>,
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

/// The needed part of the summary that the launcher prints.
#[derive(Deserialize)]
struct Summary {
    state_hash: String,
}

impl Recordings<'_> {
    /// Records each failed episode of `rows` that has no recording yet; returns how many were
    /// made. An episode that cannot be recorded is a warning.
    pub(crate) fn of(&self, rows: &Path) -> Result<u64, RecordingError> {
        let cannot = |source| RecordingError::Io {
            dir: self.dir.to_owned(),
            source,
        };
        fs::create_dir_all(self.dir).map_err(cannot)?;
        let mut made = 0;
        for failed in episodes(rows)?.failed {
            let file = self
                .dir
                .join(recording_name(failed.key.seed, failed.key.variant));
            // An episode that ended with an error has no state to compare the recording with.
            if failed.state_hash.is_empty() || file.exists() {
                continue;
            }
            if signal::stop_requested() {
                break;
            }
            // Under another name until it is complete and its hash is compared: a recording
            // that exists is not made again.
            let draft = Draft::beside(&file).map_err(cannot)?;
            match self.record(&failed, draft.path()).map_err(cannot)? {
                Ok(()) => {
                    draft.publish().map_err(cannot)?;
                    made += 1;
                }
                // The signal ended the run as well; that is not an error of the episode.
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
        // Those of the row: another answer would give another episode.
        let answers = self.answers.map(|dir| {
            let name = episode_name(failed.key.seed, failed.key.variant);
            let file = dir.join(format!("{name}.answers.jsonl"));
            ["--answers".to_owned(), file.display().to_string()]
        });
        let answers = answers.iter().flatten().cloned().collect::<Vec<_>>();
        // A name of its own, so that a cell that the user runs meanwhile is not replaced.
        let cell = format!("eval-{}", std::process::id());
        let run = Command::new(self.launcher)
            .args(["run", demo, "--policy", policy, "--seed", &seed])
            // `max` and `until-done` are what an episode of `eval` does; another speed in
            // lockstep would give the same states but take longer.
            .args(["--speed", "max", "--headless", "--until-done", "--json"])
            .args(["--cell", &cell, "--record"])
            .arg(file)
            .args(self.arguments)
            .args(set)
            .args(&failed.server)
            .args(answers.iter().map(String::as_str))
            .stdin(Stdio::null())
            .output()?;
        let text = String::from_utf8_lossy(&run.stdout);
        let summary = text.lines().last().map(serde_json::from_str::<Summary>);
        let Some(Ok(summary)) = summary else {
            let error = String::from_utf8_lossy(&run.stderr);
            let last = error.lines().last().unwrap_or("it said nothing");
            return Ok(Err(format!("the run ended with {}: {last}", run.status)));
        };
        // A recording of another run would show something that did not happen in this episode.
        if summary.state_hash != failed.state_hash {
            let (found, wanted) = (summary.state_hash, &failed.state_hash);
            return Ok(Err(format!(
                "its last state is {found}, of the row {wanted}"
            )));
        }
        Ok(Ok(()))
    }
}
