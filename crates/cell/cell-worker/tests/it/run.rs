//! A run directory with its run file, as the launcher makes it.

use std::path::PathBuf;
use std::process::ExitCode;

use cell_bus::{Keeper, RunSite};
use cell_model::Data;
use cell_run::spec::{RecordSpec, RunSpec, Speed};
use cell_run::wire;
use cell_worker::{RunError, Start};

/// Identity of the runs of the tests.
pub(crate) const RUN: u64 = 77;

/// The directory of one test. It is removed with it.
pub(crate) struct Run {
    pub(crate) dir: PathBuf,
    pub(crate) spec: RunSpec,
}

impl Drop for Run {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.dir).ok();
    }
}

impl Run {
    pub(crate) fn new(test: &str) -> Self {
        let id = std::process::id();
        let dir = PathBuf::from(format!("/dev/shm/robocell-worker-{test}-{id}"));
        std::fs::create_dir_all(&dir).unwrap();
        let spec = RunSpec {
            contract: wire::contract(),
            run: RUN,
            cell: test.to_owned(),
            demo: "reach".to_owned(),
            command: String::new(),
            policy: "follow".to_owned(),
            seed: 3,
            speed: Speed::RealTime,
            data_dir: None,
            task_program: None,
            controller_programs: Vec::new(),
            fci: Vec::new(),
            built_in_dir: Data::checkout_dir(),
            run_dir: dir.clone(),
            root: dir.join("b"),
            prefix: format!("cw{test}{id:x}_"),
            arms: 1,
            robot: None,
            script: Vec::new(),
            paused: false,
            bins: None,
            set: Vec::new(),
            replace: Vec::new(),
            action_hz: None,
            frame_hash: Vec::new(),
            policy_server: None,
            until_done: false,
            time_limit_s: None,
            real_time: false,
            page: None,
            record: RecordSpec::default(),
            incidents_dir: PathBuf::new(),
            warnings: Vec::new(),
        };
        let run = Self { dir, spec };
        run.save();
        run
    }

    /// Writes the run file.
    pub(crate) fn save(&self) {
        self.spec.save(&self.dir.join(RunSpec::FILE)).unwrap();
    }

    /// The services of the run.
    pub(crate) fn keeper(&self) -> Keeper {
        let site = RunSite {
            root: self.spec.root.clone(),
            prefix: self.spec.prefix.clone(),
        };
        Keeper::create(&site, RUN, 1).unwrap()
    }

    /// Ends the run: nothing of it stays in shared memory.
    pub(crate) fn wipe(&self, keeper: Keeper) {
        drop(keeper);
        let site = RunSite {
            root: self.spec.root.clone(),
            prefix: self.spec.prefix.clone(),
        };
        cell_bus::wipe(&site).unwrap();
    }

    /// `main` of the second start of a process of this run.
    pub(crate) fn main<E: RunError>(&self, run: impl FnOnce(&Start) -> Result<(), E>) -> ExitCode {
        let spec = self.dir.join(RunSpec::FILE).display().to_string();
        let words = ["--spec", &spec, "--generation", "2", "--arm", "1"];
        let words = words.map(str::to_owned);
        cell_worker::main_of("test-proc", &words, run)
    }
}
