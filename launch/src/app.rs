//! From the command line to what does it.

use clap::CommandFactory;
use ipc_types::operator::OperatorAction;

use crate::cli::{AssetsArgs, AssetsVerb, BenchArgs, BenchKind, Cli, Command, EvalArgs};
use crate::failure::{Context, Failure};
use crate::{bench, client, e2e, monitor_bench, record, replay, run, say, shot, sim};

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
        Command::Load(args) => client::load(args),
        Command::Record(args) => record::record(args),
        Command::Replay(args) => replay::replay(args),
        Command::Shot(args) => shot::shot(args),
        Command::Assets(args) => assets(args),
        Command::Restart(args) => client::restart(args),
        Command::Pause(args) => client::plain(args, OperatorAction::Pause),
        Command::Resume(args) => client::plain(args, OperatorAction::Resume),
        Command::Reset(args) => client::plain(args, OperatorAction::Reset),
        Command::Step(args) => client::step(args),
        Command::Task(args) => client::task(args),
        Command::Target(args) => client::target(args),
        Command::Gripper(args) => client::gripper(args),
        Command::Drag(args) => client::drag(args),
        Command::DropParts(args) => client::drop_parts(args),
        Command::AddBin(args) => client::add_bin(args),
        Command::Bt(args) => client::behaviour("bt", args),
        Command::Fsm(args) => client::behaviour("fsm", args),
        Command::Schema(args) => client::schema(*args),
        Command::Bench(args) => run_bench(args),
        Command::BenchPeer { dir, prefix } => {
            bench::peer::run(dir, prefix).map_err(Failure::configuration)
        }
        Command::Eval(args) => eval(args),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "robocell", &mut script);
            say::raw(&script);
            Ok(())
        }
        Command::Man => {
            let mut page = Vec::new();
            clap_mangen::Man::new(Cli::command())
                .render(&mut page)
                .cannot("print the manual page")?;
            say::raw(&page);
            Ok(())
        }
    }
}

fn run_bench(args: &BenchArgs) -> Result<(), Failure> {
    match args.kind {
        BenchKind::E2e => e2e::run(args.seconds, args.json),
        BenchKind::Monitor => monitor_bench::run(args.seconds, args.json),
        BenchKind::Control => core_bench("control", args.json),
        BenchKind::Physics => core_bench("physics", args.json),
        BenchKind::Behavior => sim::behavior_bench(args.json),
        BenchKind::Ipc => bench::ipc::run(args.json).map_err(Failure::configuration),
        BenchKind::Loop => bench::loop_::run(args.json).map_err(Failure::configuration),
    }
}

fn core_bench(kind: &str, json: bool) -> Result<(), Failure> {
    let mut arguments = vec!["bench".to_owned(), kind.to_owned()];
    arguments.extend(json.then(|| "--json".to_owned()));
    sim::run(&arguments)
}

/// The work is another program's: most never need what it is made of.
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
    sim::run_other("cell-assets", &arguments)
}

/// Names are checked here, so that a typo is answered before anything starts.
fn eval(args: &EvalArgs) -> Result<(), Failure> {
    let cell = run::plan::load(args.data.data.as_deref(), &args.demo, args.seeds.0, None)?;
    let policy = run::plan::choose(
        args.policy.as_deref(),
        &cell.policies,
        &cell.default_policy,
        &args.demo,
    )?;
    let seeds = format!("{}..{}", args.seeds.0, args.seeds.1);
    let jobs = args.jobs.to_string();
    let mut arguments: Vec<String> = [
        "eval", &args.demo, "--seeds", &seeds, "--policy", &policy, "--jobs", &jobs,
    ]
    .map(str::to_owned)
    .to_vec();
    if let Some(dir) = &args.data.data {
        let dir = std::fs::canonicalize(dir).cannot(format!("find {}", dir.display()))?;
        arguments.extend(["--data".to_owned(), dir.display().to_string()]);
    }
    arguments.extend(args.json.then(|| "--json".to_owned()));
    sim::run(&arguments)
}
