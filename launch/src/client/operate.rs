//! Requests of a person to physics or the launcher.

use std::time::{Duration, Instant};

use cell_model::run_spec::RunSpec;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::topic::TopicId;
use ipc_types::{GripperGoal, OperatorRequest, Pose, WorldState};

use super::Session;
use crate::cli::{
    AddBinArgs, CellArgs, DragArgs, DropPartsArgs, GripperArgs, GripperVerb, ProcessName,
    RestartArgs, StepArgs, TargetArgs, TaskArgs, TaskVerb,
};
use crate::control::{Reply, Request, ask};
use crate::failure::{Context, Failure};
use crate::run::plan::{choose, did_you_mean, load};
use crate::{say, sim};

/// Physics answers within a tick; a busy machine needs longer.
const PATIENCE: Duration = Duration::from_secs(2);
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

/// `robocell gripper open|close`.
pub(crate) fn gripper(args: &GripperArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Gripper);
    wish.arm = args.arm;
    wish.count = match args.verb {
        GripperVerb::Open => GripperGoal::Open.code(),
        GripperVerb::Close => GripperGoal::Close.code(),
    };
    send(&Session::of(&args.cell.cell)?, wish)
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

/// `robocell target X Y Z [R P Y]`.
pub(crate) fn target(args: &TargetArgs) -> Result<(), Failure> {
    let (position, angles) = match *args.values.as_slice() {
        [x, y, z] => ([x, y, z], None),
        [x, y, z, roll, pitch, yaw] => ([x, y, z], Some([roll, pitch, yaw])),
        _ => {
            return Err(Failure::usage(
                "a target has three values, or six with roll, pitch and yaw",
            ));
        }
    };
    let session = Session::of(&args.cell.cell)?;
    let orientation_wxyz = match angles {
        None => present_orientation(&session, args.arm)?,
        Some([roll, pitch, yaw]) => quaternion(roll, pitch, yaw),
    };
    let mut wish = request(OperatorAction::Target);
    wish.arm = args.arm;
    wish.pose = Pose {
        position,
        orientation_wxyz,
    };
    send(&session, wish)
}

/// The orientation the operator gave last, or the one the tool has.
fn present_orientation(session: &Session, arm: u32) -> Result<[f64; 4], Failure> {
    let bus = session.join()?;
    let mut latest = bus
        .latest::<WorldState>(TopicId::WorldState)
        .cannot("read the world")?;
    let until = Instant::now() + PATIENCE;
    while !latest.refresh() {
        if Instant::now() > until {
            return Err(Failure::configuration(
                "physics publishes no state; `robocell status` says more",
            ));
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let known = latest.get().and_then(|state| {
        let panel = &state.panel;
        if panel.target_seq > 0 && panel.target_arm == arm {
            return Some(panel.target.orientation_wxyz);
        }
        state
            .arms()
            .get(arm as usize)
            .map(|arm| arm.tcp.orientation_wxyz)
    });
    known.ok_or_else(|| Failure::configuration(format!("this cell has no arm {arm}")))
}

/// Rotation about the fixed axes x, y, z in this order, as w x y z.
fn quaternion(roll: f64, pitch: f64, yaw: f64) -> [f64; 4] {
    let ((sr, cr), (sp, cp), (sy, cy)) = (
        (roll / 2.0).sin_cos(),
        (pitch / 2.0).sin_cos(),
        (yaw / 2.0).sin_cos(),
    );
    [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
}

fn request(action: OperatorAction) -> OperatorRequest {
    OperatorRequest {
        action: action.code(),
        ..OperatorRequest::zeroed_at_identity()
    }
}

fn send(session: &Session, wish: OperatorRequest) -> Result<(), Failure> {
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
    sim::check_policy(&spec.demo, &policy, data).map_err(kept)
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

#[cfg(test)]
mod tests {
    use super::quaternion;

    #[test]
    fn roll_by_half_a_turn_points_the_tool_down() {
        let [w, x, y, z] = quaternion(std::f64::consts::PI, 0.0, 0.0);
        assert!(w.abs() < 1e-12 && (x - 1.0).abs() < 1e-12 && y.abs() < 1e-12 && z.abs() < 1e-12);
    }

    #[test]
    fn yaw_turns_about_the_vertical_axis_last() {
        let q = quaternion(0.3, -0.2, 0.9);
        assert!((q.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-12);
        let [w, x, y, z] = quaternion(0.0, 0.0, 1.0);
        assert!((w - 0.5_f64.cos()).abs() < 1e-12 && (z - 0.5_f64.sin()).abs() < 1e-12);
        assert!(x.abs() < 1e-12 && y.abs() < 1e-12);
    }
}
