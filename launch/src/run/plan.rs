//! Everything a run needs, found out before anything is started.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use cell_model::cells::replace::of_arguments;
use cell_model::cells::script::{self, ScriptLine};
use cell_model::cells::setting::Setting;
use cell_model::runs::python;
use cell_model::runs::report;
use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use cell_model::runs::wire;
use cell_model::{Cell, Data, RobotFiles, user_file};
use ipc_types::decision::POLICY_BYTES;

use super::{arms, first_page};
use crate::cli::{RobotArgs, RunArgs};
use crate::failure::{Context, Failure};
use crate::page::Page;
use crate::rundir::RunDir;
use crate::{flight, say, task_program};

/// The demo for arms that users bring.
const REACH: &str = "reach";

/// A file system with less room than this takes no recording (bytes).
const LEAST_FREE_BYTES: u64 = 1 << 20;

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
            .then(|| Page::new(args.listen.as_deref(), args.host.as_deref()))
            .transpose()?;
        let mut plan = Self::with_page(args, page)?;
        plan.waits_for_page = first_page::is_wanted(args, &plan.spec);
        plan.spec.paused |= plan.waits_for_page;
        Ok(plan)
    }

    fn with_page(args: &RunArgs, page: Option<Page>) -> Result<Self, Failure> {
        let data_dir = args.data.data.as_deref().map(absolute).transpose()?;
        let robot = robot_files(&args.robot)?;
        let cell = cell_of(args, data_dir.as_deref(), robot.as_ref())?;
        check_control(&cell)?;
        let program = task_program::of_cell(args.data.task.as_deref(), &cell, data_dir.as_deref())?;
        let controllers = task_program::of_arms(&cell, data_dir.as_deref())?;
        if args.one_process {
            check_one_process(&cell, program.as_deref(), &controllers)?;
        }
        let replace = of_arguments(&args.replace).map_err(Failure::configuration)?;
        let files = (data_dir.as_deref(), &*args.set, &*replace);
        let (policy, drawing) = policy_of(args, &cell, files, program.as_deref())?;
        let script = script_of(args, &cell)?;
        let warnings = warned(&cell, &script, &drawing);
        let dir = RunDir::of(&args.cell.cell);
        let limit = limit_of(args, &cell);
        let (run, root, prefix) = site_of(&dir)?;
        let about_arms = about_arms(args, &cell, robot.as_ref());
        let spec = RunSpec {
            contract: wire::contract(),
            run,
            cell: args.cell.cell.clone(),
            demo: args.demo.clone(),
            policy,
            seed: args.seed,
            speed: args.speed,
            data_dir,
            task_program: program,
            controller_programs: controllers,
            built_in_dir: PathBuf::new(),
            run_dir: dir.path().to_owned(),
            root,
            prefix,
            arms: u8::try_from(cell.arms.len()).unwrap_or(u8::MAX),
            robot,
            script,
            paused: args.paused,
            bins: args.bins,
            set: args.set.clone(),
            replace,
            until_done: args.until_done,
            time_limit_s: limit,
            real_time: args.speed == Speed::RealTime,
            page: page.as_ref().map(|page| page.spec(&dir)),
            record: record_of(args, &dir)?,
            incidents_dir: flight::incidents(&args.cell.cell, &dir),
            warnings,
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
            seed: self.args.seed.wrapping_add(1),
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
            policy: policy.map(str::to_owned),
            seed,
            speed,
            paused: true,
            until_done: false,
            again: false,
            timeout: None,
            script: None,
            record: None,
            bins: self.args.bins.filter(|_| demo == self.args.demo),
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
    if args.verbose || robot.is_some() || args.demo == REACH {
        arms::lines(cell, robot)
    } else {
        Vec::new()
    }
}

/// The cell as the run has it.
fn cell_of(
    args: &RunArgs,
    data_dir: Option<&Path>,
    robot: Option<&RobotFiles>,
) -> Result<Cell, Failure> {
    let mut cell = load(data_dir, &args.demo, args.seed, robot, &args.set)?;
    args.bins
        .map_or(Ok(()), |bins| cell.limit_bins(bins))
        .map_err(Failure::configuration)?;
    Ok(cell)
}

/// The policy asked for, or the demo's default, and its drawing. The task program
/// reads `[task]` and the behaviour it names now, so that an error is said before
/// anything starts.
fn policy_of(
    args: &RunArgs,
    cell: &Cell,
    files: task_program::Files<'_>,
    program: Option<&Path>,
) -> Result<(String, String), Failure> {
    let policy = policy_name(args.policy.as_deref(), cell, program)?;
    let drawing = task_program::check_policy(program, &args.demo, &policy, files)?;
    Ok((policy, drawing))
}

/// The policy asked for, or the demo's default. A Python file brings its own policies,
/// whatever the cell names.
pub(crate) fn policy_name(
    asked: Option<&str>,
    cell: &Cell,
    program: Option<&Path>,
) -> Result<String, Failure> {
    match program.filter(|program| python::is_file(program)) {
        Some(file) => {
            Ok(asked.map_or_else(|| python::policy_name(file, POLICY_BYTES), str::to_owned))
        }
        None => choose(asked, &cell.policies, &cell.default_policy, &cell.name),
    }
}

/// In one process the arms are moved by the controllers of the task program.
fn check_one_process(
    cell: &Cell,
    task: Option<&Path>,
    controllers: &[Option<PathBuf>],
) -> Result<(), Failure> {
    let others = cell.arms.iter().zip(controllers);
    for (arm, program) in others.filter(|(_, program)| program.is_some()) {
        if program.as_deref() != task {
            return Err(Failure::configuration(format!(
                "arm '{}' is moved by a program of its own; --one-process needs a task program \
                 that brings the same controllers",
                arm.name
            )));
        }
    }
    Ok(())
}

/// What the controllers will need, found out before anything starts.
fn check_control(cell: &Cell) -> Result<(), Failure> {
    for arm in &cell.arms {
        let joints = arm.robot.arm_joints.len();
        let named = |error: String| {
            let robot = &arm.robot.name;
            Failure::configuration(format!("robot '{robot}' cannot be controlled: {error}"))
        };
        let limits = arm.robot.limits().validate(joints);
        limits.map_err(|error| named(error.to_string()))?;
        let policies = arm.robot.motion_policies(cell.obstacles().count());
        policies.map_err(|error| named(error.to_string()))?;
    }
    Ok(())
}

/// The cell of `demo`, from a directory or from what is built in, with `set` in place of
/// numbers of its file.
pub(crate) fn load(
    data_dir: Option<&Path>,
    demo: &str,
    seed: u64,
    robot: Option<&RobotFiles>,
    set: &[Setting],
) -> Result<Cell, Failure> {
    let built_in = cell_files::data();
    let data = data_dir.map(|dir| Data::dir(dir).with_robots_of(&built_in));
    let data = data.unwrap_or(built_in);
    Cell::load_with(&data, demo, seed, robot, set).map_err(|error| {
        let hint = match (data_dir, robot) {
            (None, None) => data_hint(Path::new("."), demo),
            _ => "",
        };
        Failure::configuration(format!("{error}{hint}"))
    })
}

/// For those who are in the folder of their own cell.
fn data_hint(here: &Path, demo: &str) -> &'static str {
    if here.join("cells").join(format!("{demo}.toml")).is_file() {
        "; there is a cell file of that name below this folder: add `--data .`"
    } else {
        ""
    }
}

/// `asked`, if the demo has it, else its default.
pub(crate) fn choose(
    asked: Option<&str>,
    known: &[String],
    default: &str,
    demo: &str,
) -> Result<String, Failure> {
    let Some(asked) = asked else {
        return Ok(default.to_owned());
    };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    if let Some(policy) = report::policy_named(asked, &known) {
        return Ok(policy.to_owned());
    }
    let refusal = report::unknown_policy(asked, &known, demo);
    Err(Failure::configuration(refusal))
}

/// `, did you mean ...?`, where a known name is near.
pub(crate) fn did_you_mean(asked: &str, known: &[String]) -> String {
    let distance = |name: &String| strsim::damerau_levenshtein(asked, name);
    match known.iter().min_by_key(|name| distance(name)) {
        Some(name) if distance(name) <= 2.max(asked.len() / 3) => {
            format!(", did you mean `{name}`?")
        }
        _ => String::new(),
    }
}

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    fs::canonicalize(path).map_err(|error| {
        Failure::configuration(format!(
            "{}: {error}; give the path of an existing file or directory",
            path.display()
        ))
    })
}

/// The path of a file that may not exist yet, in a directory that does.
pub(crate) fn new_file(path: &Path) -> Result<PathBuf, Failure> {
    let name = path
        .file_name()
        .ok_or_else(|| Failure::usage(format!("{}: that names no file", path.display())))?;
    let parent = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let path = absolute(parent)?.join(name);
    check_new(&path)?;
    Ok(path)
}

/// Whether a file can be made at `path`, and hold something.
fn check_new(path: &Path) -> Result<(), Failure> {
    let show = path.display();
    let refuse = |why: String| {
        Err(Failure::configuration(format!(
            "cannot record to {show}: {why}; give the path of a new file"
        )))
    };
    match fs::symlink_metadata(path) {
        Ok(meta) if meta.is_dir() => return refuse("it is a directory".to_owned()),
        Ok(meta) if meta.is_file() => return refuse("it exists already".to_owned()),
        Ok(_) => return refuse("it is a device, a pipe, a socket or a link".to_owned()),
        Err(_) => {}
    }
    let made = fs::File::options().write(true).create_new(true).open(path);
    if let Err(error) = made.and_then(|_| fs::remove_file(path)) {
        return refuse(error.to_string());
    }
    let dir = path.parent().unwrap_or(Path::new("/"));
    let free = cell_rt::memory::free_bytes(dir).cannot(format!("look at {}", dir.display()))?;
    if free < LEAST_FREE_BYTES {
        return refuse(format!(
            "its file system has {free} bytes free, a second of a recording takes about 1 MB"
        ));
    }
    Ok(())
}

/// Paths are made absolute: the processes work in another directory.
pub(crate) fn robot_files(args: &RobotArgs) -> Result<Option<RobotFiles>, Failure> {
    let Some(urdf) = &args.robot else {
        return Ok(None);
    };
    let files = RobotFiles {
        urdf: absolute(urdf)?,
        xrdf: args.xrdf.as_deref().map(absolute).transpose()?,
        rmpflow: args.rmpflow.as_deref().map(absolute).transpose()?,
        tip: args.tip.clone(),
    };
    files.resolved().map(Some).map_err(Failure::configuration)
}

/// The lines of the script, if there is one.
fn script_of(args: &RunArgs, cell: &Cell) -> Result<Vec<ScriptLine>, Failure> {
    let Some(path) = &args.script else {
        return Ok(Vec::new());
    };
    let file = path.display().to_string();
    let text = user_file::read_text(path).cannot(format!("read the script {file}"))?;
    script::parse_for(&text, &file, cell).map_err(Failure::configuration)
}

/// When the run ends at the latest.
fn limit_of(args: &RunArgs, cell: &Cell) -> Option<f64> {
    let of_cell = args.until_done.then_some(cell.time_limit_s);
    args.timeout.or(of_cell)
}

/// The warnings about the inputs of the run, which are said.
fn warned(cell: &Cell, script: &[ScriptLine], drawing: &str) -> Vec<String> {
    let mut warnings = report::of_cell(cell);
    warnings.extend(report::of_script(script, drawing, cell));
    warnings.iter().for_each(say::warn);
    warnings
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_of_ones_own_needs_the_folder() {
        let checkout = Data::checkout_dir();
        assert!(data_hint(&checkout, "reach").contains("--data ."));
        assert_eq!(data_hint(&checkout, "nowhere"), "");
        assert_eq!(data_hint(&checkout.join("docs"), "reach"), "");
    }

    #[test]
    fn an_unknown_policy_is_answered_with_the_near_and_the_known_ones() {
        let known = ["fsm".to_owned(), "ifelse".to_owned()];
        assert_eq!(choose(None, &known, "fsm", "d").unwrap(), "fsm");
        assert_eq!(
            choose(Some("ifelse"), &known, "fsm", "d").unwrap(),
            "ifelse"
        );
        let message = choose(Some("ifels"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("did you mean 'ifelse'?"), "{message}");
        let message = choose(Some("quantum"), &known, "fsm", "d")
            .unwrap_err()
            .to_string();
        assert!(message.contains("known are: fsm, ifelse"), "{message}");
    }
}
