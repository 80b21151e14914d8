//! A run that can be started, and the runs that take its place.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use cell_run::spec::{PageSecrets, RunSpec, Speed};

use crate::failure::Failure;
use crate::rundir::RunDir;

/// A run that can be started.
pub struct Plan {
    /// What the processes are told.
    pub spec: RunSpec,
    /// Where the run lives.
    pub dir: RunDir,
    /// Names of the objects, in the order of the cell file.
    pub objects: Vec<String>,
    /// Policies the task can continue with.
    pub policies: Vec<String>,
    /// Whether another seed follows the end of the task.
    pub loops: bool,
    /// Kill what seems to hang.
    pub watchdog: bool,
    /// What opens its page.
    pub secrets: Option<PageSecrets>,
    /// The arms in a few lines, where they are of interest.
    pub about_arms: Vec<String>,
    /// Makes the built-in cells available to other processes, in the given directory or in
    /// the one it returns.
    pub install: fn(&Path) -> io::Result<PathBuf>,
    /// Plans the run of another scene in place of this one, on the same page.
    pub replaced: Arc<Replaced>,
}

/// See [`Plan::replaced`].
pub type Replaced = dyn Fn(Scene) -> Result<Plan, Failure> + Send + Sync;

/// A scene that takes the place of another.
#[derive(Clone, Debug)]
pub enum Scene {
    /// The same with the next seed.
    NextSeed,
    /// As a client asked for it; it waits for resume, and has no end of its own.
    Other {
        /// Name of the demo.
        demo: String,
        /// Its default where missing.
        policy: Option<String>,
        /// Seed of the scene.
        seed: u64,
        /// Its pace.
        speed: Speed,
    },
}

/// `franka-stack, policy fsm, seed 0, real time (cell `cell`)`.
pub fn title(spec: &RunSpec) -> String {
    let speed = match spec.speed {
        Speed::RealTime => "real time".to_owned(),
        Speed::Max => "lockstep, as fast as possible".to_owned(),
        Speed::Factor(factor) => format!("lockstep, {factor} times real time"),
    };
    format!(
        "{}, policy {}, seed {}, {speed} (cell `{}`)",
        spec.demo, spec.policy, spec.seed, spec.cell
    )
}
