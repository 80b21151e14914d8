//! Requests of a person to physics or the launcher.

use std::time::{Duration, Instant};

use cell_model::runs::spec::RunSpec;
use ipc_types::OperatorRequest;
use ipc_types::operator::{OperatorAction, ReplyCode};

use super::Session;
use crate::cli::{
    AddBinArgs, CellArgs, DragArgs, DropPartsArgs, ProcessName, RestartArgs, StepArgs, TaskArgs,
    TaskVerb,
};
use crate::control::{Reply, Request, ask};
use crate::failure::{Context, Failure};
use crate::run::plan::{choose, did_you_mean, load};
use crate::{say, task_program};

/// Physics answers within a tick; a busy machine needs longer.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);
/// An orderly stop takes at most a second for each process.
const DOWN_PATIENCE: Duration = Duration::from_secs(15);

/// A request without a value.
pub(crate) fn plain(args: &CellArgs, action: OperatorAction) -> Result<(), Failure> {
    send(&Session::of(&args.cell)?, request(action))
}

/// `robocell step N`.
pub(crate) fn step(args: &StepArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Step);
    wish.count = args.ticks;
    send(&Session::of(&args.cell.cell)?, wish)
}

/// `robocell task VERB`.
pub(crate) fn task(args: &TaskArgs) -> Result<(), Failure> {
    let action = match args.verb {
        TaskVerb::Start => OperatorAction::TaskStart,
        TaskVerb::Pause => OperatorAction::TaskPause,
        TaskVerb::Resume => OperatorAction::TaskResume,
        TaskVerb::Reset => OperatorAction::TaskReset,
    };
    plain(&args.cell, action)
}

/// `robocell drop-parts [N]`.
pub(crate) fn drop_parts(args: &DropPartsArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::DropParts);
    wish.count = args.count.unwrap_or(0);
    send(&Session::of(&args.cell.cell)?, wish)
}

/// `robocell add-bin [--flipped]`.
pub(crate) fn add_bin(args: &AddBinArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::AddBin);
    wish.count = u32::from(args.flipped);
    send(&Session::of(&args.cell.cell)?, wish)
}

/// `robocell drag OBJECT --to X Y Z`.
pub(crate) fn drag(args: &DragArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let spec = &session.spec;
    let cell = load(
        spec.data_dir.as_deref(),
        &spec.demo,
        spec.seed,
        spec.robot.as_ref(),
    )?;
    let names: Vec<String> = cell.objects.iter().map(|o| o.name.clone()).collect();
    let Some(index) = names.iter().position(|name| *name == args.object) else {
        let near = did_you_mean(&args.object, &names);
        let known = names.join(", ");
        return Err(Failure::configuration(format!(
            "object `{}` is unknown{near}; this cell has {known}",
            args.object
        )));
    };
    let mut wish = request(OperatorAction::Drag);
    wish.object = u32::try_from(index).unwrap_or(u32::MAX);
    wish.pose.position.copy_from_slice(&args.to);
    wish.seconds = args.seconds;
    send(&session, wish)
}

pub(super) fn request(action: OperatorAction) -> OperatorRequest {
    OperatorRequest {
        action: action.code(),
        ..OperatorRequest::zeroed_at_identity()
    }
}

pub(super) fn send(session: &Session, wish: OperatorRequest) -> Result<(), Failure> {
    let bus = session.join()?;
    let mut client = bus
        .operator_client()
        .cannot("reach the operator's service")?;
    let reply = client
        .request(wish, PATIENCE)
        .cannot("get an answer of physics")?;
    match ReplyCode::from_code(reply.code) {
        Some(ReplyCode::Accepted) => {
            say::line(format_args!(
                "accepted at {:.3} s",
                reply.header.sim_time_ns as f64 * 1.0e-9
            ));
            Ok(())
        }
        _ => Err(Failure::configuration(format!(
            "refused: {}",
            reply.message
        ))),
    }
}

/// `robocell restart PROC`.
pub(crate) fn restart(args: &RestartArgs) -> Result<(), Failure> {
    let process = match args.process {
        ProcessName::Task => "task",
        ProcessName::Controller => "controller",
        ProcessName::Physics => "physics",
        ProcessName::Monitor => "monitor",
    };
    let session = Session::of(&args.cell.cell)?;
    if args.process == ProcessName::Task {
        check_task(&session.spec, args.policy.as_deref())?;
    }
    let wish = Request::Restart {
        process: process.to_owned(),
        policy: args.policy.clone(),
    };
    accepted(ask(&session.dir.control(), &wish)?)
}

/// Nothing that runs is stopped for a task that would not start.
fn check_task(spec: &RunSpec, policy: Option<&str>) -> Result<(), Failure> {
    let data = spec.data_dir.as_deref();
    let kept = |failure: Failure| Failure {
        message: format!("{}\nthe task that runs was left alone", failure.message),
        ..failure
    };
    let cell = load(data, &spec.demo, spec.seed, spec.robot.as_ref()).map_err(kept)?;
    let policy = choose(policy, &cell.policies, &spec.policy, &spec.demo)?;
    task_program::check_policy(spec.task_program.as_deref(), &spec.demo, &policy, data)
        .map(drop)
        .map_err(kept)
}

/// `robocell down`: returns when nothing of the cell runs any more.
pub(crate) fn down(args: &CellArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell)?;
    accepted(ask(&session.dir.control(), &Request::Down)?)?;
    let until = Instant::now() + DOWN_PATIENCE;
    while session
        .dir
        .holder()
        .is_some_and(|holder| holder.pid == session.holder.pid)
    {
        if Instant::now() > until {
            let pid = session.holder.pid;
            return Err(Failure::configuration(format!(
                "the launcher does not end: kill -9 {pid}"
            )));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn accepted(reply: Reply) -> Result<(), Failure> {
    if reply.ok {
        say::line(reply.message);
        return Ok(());
    }
    Err(Failure::configuration(reply.message))
}
