//! Everything a run needs, found out before anything is started.

pub(crate) mod cell;
mod inputs;
pub(crate) mod paths;
pub(crate) mod policy;

use std::fs;
use std::io::Read;
use std::path::PathBuf;

use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use cell_model::runs::wire;
use cell_model::{Cell, RobotFiles};

use super::{arms, first_page};
use crate::cli::{JobArgs, RunArgs, SceneArgs};
use crate::failure::{Context, Failure};
use crate::flight;
use crate::page::Page;
use crate::rundir::RunDir;
use inputs::Inputs;
use paths::new_file;

/// The demo for arms that users bring.
const REACH: &str = "reach";

/// A run that can be started.
#[derive(Debug)]
pub struct Plan {
    /// What the processes are told.
    pub spec: RunSpec,
    /// Where the run lives.
    pub(crate) dir: RunDir,
    /// Names of the objects, in the order of the cell file.
    pub(crate) objects: Vec<String>,
    /// Policies the task can continue with.
    pub(crate) policies: Vec<String>,
    /// The run has no end of its own.
    pub(crate) stays: bool,
    /// Kill what seems to hang.
    pub(crate) watchdog: bool,
    /// Its page.
    pub(crate) page: Option<Page>,
    /// The arms in a few lines, where they are of interest.
    pub(crate) about_arms: Vec<String>,
    /// The cell is paused until its page is open, or for some seconds.
    pub(super) waits_for_page: bool,
    /// What was asked for.
    args: RunArgs,
}

impl Plan {
    /// Resolves the command line; the first thing that is wrong is the error.
    pub fn resolve(args: &RunArgs) -> Result<Self, Failure> {
        let page = (!args.headless && !args.one_process)
            .then(|| Page::new(&args.page))
            .transpose()?;
        let mut plan = Self::with_page(args, page)?;
        plan.waits_for_page = first_page::is_wanted(args, &plan.spec);
        plan.spec.paused |= plan.waits_for_page;
        Ok(plan)
    }

    fn with_page(args: &RunArgs, page: Option<Page>) -> Result<Self, Failure> {
        let inputs = Inputs::read(args)?;
        let cell = inputs.cell;
        let dir = RunDir::of(&args.cell.cell);
        let limit = limit_of(args, &cell);
        let (run, root, prefix) = site_of(&dir)?;
        let about_arms = about_arms(args, &cell, inputs.robot.as_ref());
        let spec = RunSpec {
            contract: wire::contract(),
            run,
            cell: args.cell.cell.clone(),
            demo: args.demo.clone(),
            policy: inputs.policy,
            seed: args.scene.seed,
            speed: args.scene.speed,
            data_dir: inputs.data_dir,
            task_program: inputs.program,
            controller_programs: inputs.controllers,
            built_in_dir: PathBuf::new(),
            run_dir: dir.path().to_owned(),
            root,
            prefix,
            arms: u8::try_from(cell.arms.len()).unwrap_or(u8::MAX),
            robot: inputs.robot,
            script: inputs.script,
            paused: args.paused,
            bins: args.job.bins,
            set: args.set.clone(),
            replace: inputs.replace,
            until_done: args.until_done,
            time_limit_s: limit,
            real_time: args.scene.speed == Speed::RealTime,
            page: page.as_ref().map(|page| page.spec(&dir)),
            record: record_of(args, &dir)?,
            incidents_dir: flight::incidents(&args.cell.cell, &dir),
            warnings: inputs.warnings,
        };
        Ok(Self {
            spec,
            dir,
            objects: cell.objects.iter().map(|o| o.name.clone()).collect(),
            policies: cell.policies,
            stays: limit.is_none(),
            watchdog: !args.no_watchdog,
            page,
            about_arms,
            waits_for_page: false,
            args: args.clone(),
        })
    }

    /// Whether another seed follows the end of the task.
    pub(crate) fn loops(&self) -> bool {
        self.args.again
    }

    /// The same run with the next seed.
    pub(crate) fn next_seed(&self) -> Result<Self, Failure> {
        let args = RunArgs {
            scene: SceneArgs {
                seed: self.args.scene.seed.wrapping_add(1),
                ..self.args.scene.clone()
            },
            paused: false,
            ..self.args.clone()
        };
        Self::with_page(&args, self.kept_page())
    }

    fn kept_page(&self) -> Option<Page> {
        let page = self.page.clone();
        page.map(|page| page.with_secrets_of(&self.dir))
    }

    /// The run of another scene in place of this one, on the same page; it waits
    /// for resume, and has no end of its own.
    pub(crate) fn replaced(
        &self,
        demo: &str,
        policy: Option<&str>,
        seed: u64,
        speed: Speed,
    ) -> Result<Self, Failure> {
        let args = RunArgs {
            demo: demo.to_owned(),
            scene: SceneArgs {
                policy: policy.map(str::to_owned),
                seed,
                speed,
            },
            job: JobArgs {
                timeout: None,
                script: None,
                bins: self.args.job.bins.filter(|_| demo == self.args.demo),
                replace: self.args.job.replace.clone(),
            },
            paused: true,
            until_done: false,
            again: false,
            record: None,
            set: Some(self.args.set.clone())
                .filter(|_| demo == self.args.demo)
                .unwrap_or_default(),
            robot: Some(self.args.robot.clone())
                .filter(|_| demo == self.args.demo)
                .unwrap_or_default(),
            ..self.args.clone()
        };
        Self::with_page(&args, self.kept_page())
    }
}

/// The arms in a few lines, where the run is about them.
fn about_arms(args: &RunArgs, cell: &Cell, robot: Option<&RobotFiles>) -> Vec<String> {
    if robot.is_some() || args.demo == REACH {
        arms::lines(cell, robot)
    } else {
        Vec::new()
    }
}

/// When the run ends at the latest.
fn limit_of(args: &RunArgs, cell: &Cell) -> Option<f64> {
    let of_cell = args.until_done.then_some(cell.time_limit_s);
    args.job.timeout.or(of_cell)
}

/// What is kept of the run: the ring, and a file where one was asked for.
fn record_of(args: &RunArgs, dir: &RunDir) -> Result<RecordSpec, Failure> {
    Ok(RecordSpec {
        file: args.record.as_deref().map(new_file).transpose()?,
        ..flight::ring(&args.cell.cell, dir)
    })
}

/// A number no other run has, and where on this machine its messages go.
fn site_of(dir: &RunDir) -> Result<(u64, PathBuf, String), Failure> {
    let run = random_run()?;
    let (root, prefix) = dir.site(run);
    Ok((run, root, prefix))
}

fn random_run() -> Result<u64, Failure> {
    let mut bytes = [0_u8; 8];
    let mut source = fs::File::open("/dev/urandom").cannot("open /dev/urandom")?;
    source.read_exact(&mut bytes).cannot("read /dev/urandom")?;
    Ok(u64::from_ne_bytes(bytes).max(1))
}
