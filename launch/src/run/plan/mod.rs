//! Everything a run needs, found out before anything is started.

pub(crate) mod cell;
mod fci;
mod inputs;
pub(crate) mod paths;
pub(crate) mod policy;
pub(crate) mod server;

use std::fs;
use std::io::Read;
use std::path::PathBuf;
use std::sync::Arc;

use cell_model::runs::policy_server::PolicyServer;
use cell_model::{Cell, RobotFiles};
use cell_run::spec::{RecordSpec, RunSpec, Speed};
use cell_run::wire;
use supervisor::failure::{Context, Failure};
use supervisor::flight;
use supervisor::run::plan::{Plan, Replaced, Scene};
use supervisor::rundir::RunDir;

use super::arms;
use crate::args::{JobArgs, RunArgs, SceneArgs};
use crate::page::Page;
use inputs::Inputs;
use paths::new_file;

/// The demo for arms that users bring.
const REACH: &str = "reach";

/// Resolves the command line; the first thing that is wrong is the error.
pub fn resolve(args: &RunArgs) -> Result<Plan, Failure> {
    let page = (!args.headless && !args.one_process)
        .then(|| Page::new(&args.page))
        .transpose()?;
    let plan = with_page(args, page)?;
    // Not for the scene after this one: its interface has the address of this one.
    fci::check_free(&plan.spec.fci)?;
    Ok(plan)
}

fn with_page(args: &RunArgs, page: Option<Page>) -> Result<Plan, Failure> {
    let inputs = Inputs::read(args)?;
    let cell = inputs.cell;
    let dir = RunDir::of(&args.cell.cell)?;
    let limit = limit_of(args, &cell);
    let (run, root, prefix) = site_of(&dir)?;
    let watchdog = is_watched(args, inputs.policy_server.as_ref());
    let about_arms = about_arms(args, &cell, inputs.robot.as_ref());
    let spec = RunSpec {
        contract: wire::contract(),
        run,
        cell: args.cell.cell.clone(),
        command: String::new(),
        demo: args.demo.clone(),
        policy: inputs.policy,
        seed: args.scene.seed,
        speed: args.scene.speed,
        data_dir: inputs.data_dir,
        task_program: inputs.program,
        controller_programs: inputs.controllers,
        fci: inputs.fci,
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
        action_hz: None,
        frame_hash: Vec::new(),
        policy_server: inputs.policy_server,
        until_done: args.until_done,
        time_limit_s: limit,
        real_time: args.scene.speed == Speed::RealTime,
        // After the inputs were checked: it may build the page, for minutes.
        page: page.as_ref().map(|page| page.spec(&dir)),
        record: record_of(args, &dir)?,
        incidents_dir: flight::incidents(&args.cell.cell, &dir),
        warnings: inputs.warnings,
    };
    Ok(Plan {
        spec,
        dir,
        objects: cell.objects.iter().map(|o| o.name.clone()).collect(),
        policies: cell.policies,
        loops: args.again,
        watchdog,
        secrets: page.as_ref().map(|page| page.secrets().clone()),
        about_arms,
        install: cell_files::install,
        replaced: replaced(args, page),
    })
}

/// Whether processes that seem to hang are ended.
fn is_watched(args: &RunArgs, server: Option<&PolicyServer>) -> bool {
    // Simulation waits for a policy server in lockstep, for longer than a process may hang.
    let waits = server.is_some_and(|server| !server.real_time);
    !args.no_watchdog && !waits
}

/// The plan of another scene, in place of a run with these arguments.
fn replaced(args: &RunArgs, page: Option<Page>) -> Arc<Replaced> {
    let args = args.clone();
    Arc::new(move |scene| with_page(&args_of(&args, scene), page.clone()))
}

/// The command line of `scene`, after a run with that of `args`.
fn args_of(args: &RunArgs, scene: Scene) -> RunArgs {
    match scene {
        Scene::NextSeed => RunArgs {
            scene: SceneArgs {
                seed: args.scene.seed.wrapping_add(1),
                ..args.scene.clone()
            },
            // `--paused` is about the first scene: a loop continues without a person.
            paused: false,
            ..args.clone()
        },
        Scene::Other {
            demo,
            policy,
            seed,
            speed,
        } => {
            // These options name parts of a cell file, which another demo may not have.
            let is_same = demo == args.demo;
            RunArgs {
                demo,
                scene: SceneArgs {
                    policy,
                    seed,
                    speed,
                },
                job: JobArgs {
                    timeout: None,
                    script: None,
                    bins: args.job.bins.filter(|_| is_same),
                    replace: args.job.replace.clone(),
                },
                paused: true,
                until_done: false,
                again: false,
                record: None,
                set: Some(args.set.clone())
                    .filter(|_| is_same)
                    .unwrap_or_default(),
                controllers: Some(args.controllers.clone())
                    .filter(|_| is_same)
                    .unwrap_or_default(),
                robot: Some(args.robot.clone())
                    .filter(|_| is_same)
                    .unwrap_or_default(),
                ..args.clone()
            }
        }
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

/// The recordings of the run: the ring, and a file if one was asked for.
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
    // The number of a run is never 0 (`ipc_types::Header`).
    Ok(u64::from_ne_bytes(bytes).max(1))
}
