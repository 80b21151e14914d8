//! Rows of many episodes into a file, for `eval --out`.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use cell_model::cells::sweep::Cases;
use cell_model::runs::spec::RunSpec;
use cell_rt::signal;
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

/// Which rows, and where to.
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
    /// File of the rows.
    pub(crate) out: &'a Path,
    /// More files that episodes depend on.
    pub(crate) inputs: &'a [PathBuf],
    /// See [`Plan::arguments`].
    pub(crate) arguments: Vec<String>,
}

/// What is in the file now.
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

/// Runs the episodes whose rows are missing, until all are there or a signal asks to stop.
pub(crate) fn write(program: &Program, order: &Order<'_>) -> Result<Written, RowsError> {
    let plan = Plan {
        identity: identity(program, order)?,
        seeds: order.seeds,
        shard: order.shard,
        variants: *order.cases.sweep().variants().end(),
        arguments: order.arguments.clone(),
    };
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
    signal::install_stop_handler().ok();
    let host = host_name();
    let spec = RunSpec {
        seed: order.seeds[0],
        ..order.spec.clone()
    };
    Episodes {
        program,
        spec: &spec,
        jobs: order.jobs,
        stop: &signal::stop_requested,
    }
    .run(left, &|ended| {
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        let goes_on = state.take(&plan.identity, &spec, (&host, &folders), &ended);
        progress.print(|| warned.tell(&ended.warnings));
        progress.row(state.failed);
        goes_on
    });
    drop(progress);
    let State {
        file,
        failed,
        error,
    } = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(error) = error {
        return Err(error.into());
    }
    let rows = file.rows();
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
    /// Appends the row of an episode; whether to go on.
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
        row.message = row.message.map(|message| folders.left_out_of(&message));
        self.failed += u64::from(row.outcome != RowOutcome::Done);
        #[allow(
            clippy::disallowed_methods,
            reason = "for people, who know the calendar; no episode depends on it"
        )]
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
                self.error = Some(error);
                false
            }
        }
    }
}

/// The folders of the inputs. Sentences in rows name files without them: rows are the same
/// on every machine.
struct Folders(Vec<String>);

impl Folders {
    fn of(order: &Order<'_>) -> Self {
        let files = order.inputs.iter().filter_map(|file| file.parent());
        let robot = order.spec.robot.iter();
        let robot = robot.filter_map(|robot| robot.urdf.parent());
        let all = order.spec.data_dir.as_deref().into_iter().chain(files);
        let all = all.chain(robot).map(|dir| format!("{}/", dir.display()));
        Self(
            all.filter(|dir| dir.starts_with('/') && dir.len() > 1)
                .collect(),
        )
    }

    fn left_out_of(&self, sentence: &str) -> String {
        let shorter = |text: String, dir: &String| text.replace(dir.as_str(), "");
        self.0.iter().fold(sentence.to_owned(), shorter)
    }
}

/// Build, and hash of all that an episode depends on but its seed.
fn identity(program: &Program, order: &Order<'_>) -> Result<Identity, RowsError> {
    let input = |path: &Path| {
        let path = path.to_owned();
        move |source| RowsError::Input { path, source }
    };
    let own = Path::new("/proc/self/exe");
    let build = own_build().map_err(input(own))?;
    let mut inputs = Inputs::default();
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
    let extension = extension_module();
    let files = robot.chain(order.inputs).chain(&extension);
    for (index, path) in files.enumerate() {
        let added = inputs.add_file(&format!("file {index}"), path);
        added.map_err(input(path))?;
    }
    let spec = order.spec;
    let tip = spec.robot.as_ref().and_then(|robot| robot.tip.clone());
    let mut options = serde_json::json!({
        "demo": spec.demo, "policy": spec.policy, "script": spec.script, "bins": spec.bins,
        "time_limit_s": spec.time_limit_s, "tip": tip, "sweep": order.cases.sweep(),
    });
    // Rows of runs without it are not of other inputs than before.
    if !spec.replace.is_empty() {
        options["replace"] = serde_json::json!(spec.replace);
    }
    inputs.add("options", options.to_string().as_bytes());
    Ok(Identity {
        build,
        inputs: inputs.hash(),
    })
}

/// The extension module that runs this code, where the program of the process is Python.
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

/// Of this machine; for the side file alone.
fn host_name() -> String {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname");
    name.map_or_else(|_| String::new(), |name| name.trim().to_owned())
}
