//! Rows of many episodes into a file, for `eval --out`.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use cell_model::cells::sweep::Cases;
use cell_rt::signal;
use cell_run::spec::RunSpec;
use cell_sim::episodes::{self, Ended, Episodes};
use cell_sim::{Program, SimError};
use evaluation::EvaluationError;
use evaluation::identity::{Identity, Inputs, own_build};
use evaluation::info::{Episode, Plan};
use evaluation::row::{Row, RowOutcome};
use evaluation::rows_file::RowsFile;
use evaluation::shard::Shard;

use crate::progress::Progress;
use crate::warned::Warned;

/// The rows to write, and their file.
pub(crate) struct Order<'a> {
    /// Everything but the seed.
    pub(crate) spec: &'a RunSpec,
    /// Numbers that are replaced.
    pub(crate) cases: &'a Cases,
    /// First and last seed of all shards.
    pub(crate) seeds: [u64; 2],
    /// The shard.
    pub(crate) shard: Shard,
    /// Episodes at the same time.
    pub(crate) jobs: usize,
    /// Directory for a recording of each episode.
    pub(crate) record: Option<&'a Path>,
    /// File of the rows.
    pub(crate) out: &'a Path,
    /// More files that episodes depend on.
    pub(crate) inputs: &'a [PathBuf],
    /// See [`Plan::arguments`].
    pub(crate) arguments: Vec<String>,
}

/// The content of the file after the call.
pub(crate) struct Written {
    /// Rows of this shard.
    pub(crate) all: u64,
    /// Those in the file.
    pub(crate) rows: u64,
    /// Of those written by this process: all, and those that did not end done.
    pub(crate) new: (u64, u64),
}

/// Why rows could not be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RowsError {
    /// The file.
    #[error(transparent)]
    File(#[from] EvaluationError),
    /// The cell, the robot or the task.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A file that is an input.
    #[error("{path}: {source}", path = path.display())]
    Input {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Runs the episodes without a row, until all have one or a signal requests a stop.
pub(crate) fn write(program: &Program, order: &Order<'_>) -> Result<Written, RowsError> {
    let plan = Plan {
        identity: identity(program, order)?,
        seeds: order.seeds,
        shard: order.shard,
        variants: *order.cases.sweep().variants().end(),
        arguments: order.arguments.clone(),
    };
    // The file is locked from here on: a second process with the same command would write the
    // same seeds (ADR 0023).
    let file = RowsFile::open(order.out, &plan)?;
    let left = file.left();
    let left = left.map(|key| order.cases.case(key.seed, key.variant));
    let (before, all) = (file.rows(), plan.rows());
    let progress = Progress::of_rows(before, all);
    let warned = Warned::default();
    let folders = Folders::of(order);
    let state = Mutex::new(State {
        file,
        failed: 0,
        error: None,
    });
    // After the file was opened, so that its errors end the command as any other.
    signal::install_stop_handler().ok();
    let host = host_name();
    let spec = RunSpec {
        seed: order.seeds[0],
        ..order.spec.clone()
    };
    Episodes {
        program,
        spec: &spec,
        record: order.record,
        jobs: order.jobs,
        stop: &signal::stop_requested,
    }
    // Appended in the order in which episodes end: in the order of seeds a slow episode would
    // hold back finished rows, which a kill would lose (ADR 0023).
    .run(left, &|ended| {
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        let goes_on = state.take(&plan.identity, &spec, (&host, &folders), &ended);
        progress.print(|| warned.show(&ended.warnings));
        progress.row(state.failed);
        goes_on
    });
    // Removed before a warning or the result is printed.
    drop(progress);
    let state = state.into_inner();
    finished(state.unwrap_or_else(PoisonError::into_inner), before, all)
}

/// The result of a run over a file that had `before` of `all` rows.
fn finished(state: State, before: u64, all: u64) -> Result<Written, RowsError> {
    let State {
        file,
        failed,
        error,
    } = state;
    if let Some(error) = error {
        return Err(error.into());
    }
    let rows = file.rows();
    // Only a complete file is sorted, into a copy that replaces it: files of all shards become
    // the bytes of an unsharded run (ADR 0023).
    if rows == all {
        file.finish()?;
    }
    Ok(Written {
        all,
        rows,
        new: (rows - before, failed),
    })
}

struct State {
    file: RowsFile,
    failed: u64,
    error: Option<EvaluationError>,
}

impl State {
    /// Appends the row of an episode; returns whether to continue.
    fn take(
        &mut self,
        identity: &Identity,
        spec: &RunSpec,
        (host, folders): (&str, &Folders),
        ended: &Ended,
    ) -> bool {
        let names = (spec.demo.as_str(), spec.policy.as_str());
        let mut row = match &ended.result {
            Ok(summary) => Row::of(identity, &ended.case, summary),
            Err(reason) => Row::error(identity, names, &ended.case, reason.clone()),
        };
        // Rows must not depend on the folder of a user: they are compared between machines.
        row.message = row.message.map(|message| folders.left_out_of(&message));
        self.failed += u64::from(row.outcome != RowOutcome::Done);
        #[allow(
            clippy::disallowed_methods,
            reason = "for people; no episode depends on it"
        )]
        // Time and host are in the side file, so that rows depend on inputs alone (ADR 0023).
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let episode = Episode {
            seed: ended.case.seed,
            variant: ended.case.variant,
            host: host.to_owned(),
            ended_s: since.map_or(0, |since| since.as_secs()),
            wall_time_s: ended.wall_time.as_secs_f64(),
        };
        match self.file.append(&row, &episode) {
            Ok(()) => true,
            Err(error) => {
                // The episodes stop: without a file each further one would be lost.
                self.error = Some(error);
                false
            }
        }
    }
}

/// The folders of the inputs. Messages in rows name files without them, so that rows are the
/// same on every machine.
struct Folders(Vec<String>);

impl Folders {
    fn of(order: &Order<'_>) -> Self {
        let files = order.inputs.iter().filter_map(|file| file.parent());
        let robot = order.spec.robot.iter();
        let robot = robot.filter_map(|robot| robot.urdf.parent());
        let all = order.spec.data_dir.as_deref().into_iter().chain(files);
        // Not `/`: it is no user's folder, and `//` may be part of a message.
        let all = all
            .chain(robot)
            .filter(|dir| dir.is_absolute() && *dir != Path::new("/"));
        Self(all.map(|dir| format!("{}/", dir.display())).collect())
    }

    fn left_out_of(&self, sentence: &str) -> String {
        let shorter = |text: String, dir: &String| text.replace(dir.as_str(), "");
        self.0.iter().fold(sentence.to_owned(), shorter)
    }
}

/// The build, and the hash of all inputs of an episode except its seed.
fn identity(program: &Program, order: &Order<'_>) -> Result<Identity, RowsError> {
    let input = |path: &Path| {
        let path = path.to_owned();
        move |source| RowsError::Input { path, source }
    };
    // The running program itself, also if the file was replaced since its start.
    let own = Path::new("/proc/self/exe");
    let build = own_build().map_err(input(own))?;
    let mut inputs = Inputs::default();
    // The first seed represents all: the same files are read for each of them.
    let first = RunSpec {
        seed: order.seeds[0],
        ..order.spec.clone()
    };
    for (name, text) in episodes::files(program, &first)? {
        inputs.add(&name, text.as_bytes());
    }
    let robot = order.spec.robot.iter().flat_map(|robot| {
        let more = [&robot.xrdf, &robot.rmpflow].into_iter().flatten();
        std::iter::once(&robot.urdf).chain(more)
    });
    // With Python the program is the interpreter, and this code is in a library.
    let extension = extension_module();
    let files = robot.chain(order.inputs).chain(&extension);
    for (index, path) in files.enumerate() {
        let added = inputs.add_file(&format!("file {index}"), path);
        added.map_err(input(path))?;
    }
    let spec = order.spec;
    // The options are part of the hash: rows of two commands with other options are not merged.
    let tip = spec.robot.as_ref().and_then(|robot| robot.tip.clone());
    let mut options = serde_json::json!({
        "demo": spec.demo, "policy": spec.policy, "script": spec.script, "bins": spec.bins,
        "time_limit_s": spec.time_limit_s, "tip": tip, "sweep": order.cases.sweep(),
    });
    // Rows written before this option existed keep their hash.
    if !spec.replace.is_empty() {
        options["replace"] = serde_json::json!(spec.replace);
    }
    if let Some(rate) = spec.action_hz {
        options["rate"] = serde_json::json!(rate);
    }
    if !spec.frame_hash.is_empty() {
        options["frame_hash"] = serde_json::json!(spec.frame_hash);
    }
    if let Some(server) = &spec.policy_server {
        options["names"] = serde_json::json!(server.names);
    }
    inputs.add("options", options.to_string().as_bytes());
    Ok(Identity {
        build,
        inputs: inputs.hash(),
    })
}

/// The extension module that contains this code, where the program of the process is Python.
fn extension_module() -> Option<PathBuf> {
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let mapped = maps
        .lines()
        .filter_map(|line| line.find('/').map(|at| Path::new(&line[at..])));
    let is_own = |path: &&Path| {
        let name = path.file_name().map(|name| name.to_string_lossy());
        name.is_some_and(|name| name.starts_with("_core."))
    };
    mapped.filter(is_own).map(Path::to_owned).next()
}

/// Name of this machine, for the side file alone.
fn host_name() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname");
    name.map_or_else(|_| String::new(), |name| name.trim().to_owned())
}

#[cfg(test)]
mod tests;
