//! The inputs of a run: its cell, programs, policy and script.

use std::path::PathBuf;

use cell_model::cells::replace::{Replace, of_arguments};
use cell_model::cells::script::{self, ScriptLine};
use cell_model::runs::policy_server::PolicyServer;
use cell_model::{Cell, RobotFiles, user_file};
use cell_run::report;
use cell_run::spec::Fci;
use supervisor::failure::{Context, Failure};

use super::cell::{cell_of, check_control, check_one_process, robot_files};
use super::fci;
use super::paths::absolute;
use super::policy::policy_of;
use super::server::server_of;
use crate::args::RunArgs;
use crate::{say, task_program};

/// The files and programs of a run, read and checked.
pub(super) struct Inputs {
    pub(super) data_dir: Option<PathBuf>,
    pub(super) robot: Option<RobotFiles>,
    pub(super) cell: Cell,
    /// The task program.
    pub(super) program: Option<PathBuf>,
    /// The controller program of each arm.
    pub(super) controllers: Vec<Option<PathBuf>>,
    /// By arm: its Franka control interface.
    pub(super) fci: Vec<Option<Fci>>,
    /// Answers of leaves that are not run.
    pub(super) replace: Vec<Replace>,
    pub(super) policy: String,
    pub(super) script: Vec<ScriptLine>,
    /// The use of a policy behind a socket.
    pub(super) policy_server: Option<PolicyServer>,
    /// They are said already.
    pub(super) warnings: Vec<String>,
}

impl Inputs {
    /// The inputs that the command line names; the first that is wrong is the error.
    pub(super) fn read(args: &RunArgs) -> Result<Self, Failure> {
        let data_dir = args.data.data.as_deref().map(absolute).transpose()?;
        let robot = robot_files(&args.robot, data_dir.as_deref())?;
        let mut cell = cell_of(args, data_dir.as_deref(), robot.as_ref())?;
        let fci = fci::controllers_of(&args.controllers, &mut cell)?;
        // Before the task program is asked: it may have to be built first.
        check_control(&cell)?;
        let program = task_program::of_cell(
            args.data.program.task.as_deref(),
            &cell,
            data_dir.as_deref(),
        )?;
        let controllers = task_program::of_arms(&cell, data_dir.as_deref())?;
        if args.one_process {
            check_one_process(&cell, program.as_deref(), &controllers)?;
        }
        let replace = of_arguments(&args.job.replace).map_err(Failure::configuration)?;
        let files = (data_dir.as_deref(), &*args.set, &*replace);
        let (policy, drawing) = policy_of(args, &cell, files, program.as_deref())?;
        let script = script_of(args, &cell)?;
        let policy_server = server_of(args, &policy)?;
        let warnings = warned(&cell, &script, &drawing);
        Ok(Self {
            data_dir,
            robot,
            cell,
            program,
            controllers,
            fci,
            replace,
            policy,
            script,
            policy_server,
            warnings,
        })
    }
}

/// The lines of the script, if there is one.
fn script_of(args: &RunArgs, cell: &Cell) -> Result<Vec<ScriptLine>, Failure> {
    let Some(path) = &args.job.script else {
        return Ok(Vec::new());
    };
    let file = path.display().to_string();
    let text = user_file::read_text(path).cannot(format!("read the script {file}"))?;
    script::parse_for(&text, &file, cell).map_err(Failure::configuration)
}

/// The warnings about the inputs of the run, which are said.
fn warned(cell: &Cell, script: &[ScriptLine], drawing: &str) -> Vec<String> {
    let mut warnings = report::of_cell(cell);
    warnings.extend(report::of_script(script, drawing, cell));
    warnings.iter().for_each(say::warn);
    warnings
}
