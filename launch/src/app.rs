//! From the command line to what does it.

use clap::ValueEnum;
use ipc_types::operator::OperatorAction;
use supervisor::failure::Failure;

use crate::args::{AssetsArgs, AssetsVerb, BenchArgs, Cli, Command, ExportArgs, SpheresArgs};
use crate::eval;
use crate::progress::Progress;
use crate::{
    camera, chaos, client, complete, man, new, plot, record, replay, run, schema, task_program,
};

/// Does what the command line says.
pub(crate) fn dispatch(cli: &Cli) -> Result<(), Failure> {
    match &cli.command {
        Command::Run(args) => run::run(args),
        Command::List(args) => client::list(args),
        Command::Status(args) => client::status(args),
        Command::Top(args) => client::top(args),
        Command::Down(args) => client::down(args),
        Command::Doctor(args) => client::doctor(args),
        Command::Logs(args) => client::logs(args),
        Command::Incident(args) => client::incident(args),
        Command::Load(args) => client::load(args),
        Command::Record(args) => record::record(args),
        Command::Plot(args) => plot::plot(args),
        Command::Replay(args) => replay::replay(args),
        Command::Export(args) => export(args),
        Command::Camera(args) => camera::run(args),
        Command::Assets(args) => assets(args),
        Command::Spheres(args) => spheres(args),
        Command::Restart(args) => client::restart(args),
        Command::Pause(args) => client::plain(args, OperatorAction::Pause),
        Command::Resume(args) => client::plain(args, OperatorAction::Resume),
        Command::Reset(args) => client::plain(args, OperatorAction::Reset),
        Command::Step(args) => client::step(args),
        Command::Speed(args) => client::speed(args),
        Command::Break(args) => client::breakpoint(args),
        Command::Task(args) => client::task(args),
        Command::Target(args) => client::target(args),
        Command::Joints(args) => client::joints(args),
        Command::Gripper(args) => client::gripper(args),
        Command::Grasp(args) => client::grasp(args),
        Command::Drag(args) => client::drag(args),
        Command::DropParts(args) => client::drop_parts(args),
        Command::AddBin(args) => client::add_bin(args),
        Command::Bt(args) => client::tree(args),
        Command::Fsm(args) => client::behaviour("fsm", &args.verb),
        Command::Schema(args) => schema::schema(args),
        Command::Bench(args) => run_bench(args),
        Command::Chaos(args) => chaos::chaos(args),
        Command::Eval(args) => eval::run(args),
        Command::New(args) => new::new(args),
        Command::Completions { shell } => {
            complete::script(*shell);
            Ok(())
        }
        Command::Complete(args) => {
            complete::names(args);
            Ok(())
        }
        Command::Man(args) => man::man(args),
    }
}

/// Measuring is another program's work: the libraries it compares with are no
/// dependencies of a cell.
fn run_bench(args: &BenchArgs) -> Result<(), Failure> {
    let kind = args.kind.to_possible_value();
    let kind = kind
        .as_ref()
        .map_or("", clap::builder::PossibleValue::get_name);
    let seconds = args.seconds.to_string();
    let mut arguments: Vec<String> = [kind, "--seconds", &seconds].map(str::to_owned).to_vec();
    arguments.extend(args.json.then(|| "--json".to_owned()));
    let _progress = Progress::new(format!("bench {kind}"));
    task_program::run_other("robocell-bench", &arguments)
}

/// Fetching meshes is another program's work: most users never need its dependencies.
fn assets(args: &AssetsArgs) -> Result<(), Failure> {
    let mut arguments = Vec::new();
    match &args.verb {
        AssetsVerb::List => arguments.push("list".to_owned()),
        AssetsVerb::Fetch { from, force } => {
            arguments.push("fetch".to_owned());
            if let Some(from) = from {
                arguments.extend(["--from".to_owned(), from.display().to_string()]);
            }
            arguments.extend(force.then(|| "--force".to_owned()));
        }
    }
    task_program::run_other("cell-assets", &arguments)
}

/// Writing data sets is another program's work as well.
fn export(args: &ExportArgs) -> Result<(), Failure> {
    // The launcher is built without `parquet`, which is 40 packages (ADR 37).
    let mut arguments = vec!["lerobot".to_owned(), args.lerobot.display().to_string()];
    arguments.extend(args.files.iter().map(|file| file.display().to_string()));
    for name in &args.camera {
        arguments.extend(["--camera".to_owned(), name.clone()]);
    }
    let _progress = Progress::new("export".to_owned());
    task_program::run_other("robocell-export", &arguments)
}

/// Reading meshes is another program's work, too.
fn spheres(args: &SpheresArgs) -> Result<(), Failure> {
    // No process of a cell reads meshes, so only `cell-spheres` has their readers (ADR 22).
    let mut arguments = vec![args.urdf.display().to_string()];
    arguments.extend(["--margin".to_owned(), args.margin.to_string()]);
    arguments.extend(["--most".to_owned(), args.most.to_string()]);
    if let Some(tip) = &args.tip {
        arguments.extend(["--tip".to_owned(), tip.clone()]);
    }
    for package in &args.package {
        arguments.extend(["--package".to_owned(), package.clone()]);
    }
    task_program::run_other("cell-spheres", &arguments)
}
