//! Requests of a person to physics or the launcher.

use std::time::{Duration, Instant};

use cell_bus::Bus;
use cell_model::Cell;
use cell_run::spec::Speed;
use ipc_types::decision::Outcome;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::world::{FLAG_PAUSED, OBJECT_DRAGGED, PauseCause};
use ipc_types::{Decision, OperatorReply, OperatorRequest, WorldState};
use supervisor::control::{Reply, Request, ask};
use supervisor::failure::{Context, Failure};

use super::follow::{Follower, PATIENCE};
use super::picture::Picture;
use super::session::Session;
use crate::args::{
    AddBinArgs, CellArgs, DragArgs, DropPartsArgs, SpeedArgs, StepArgs, TaskArgs, TaskVerb,
};
use crate::say;
use crate::suggestion::did_you_mean;

/// A request shows in the state within this many ticks.
const TAKES_EFFECT_TICKS: u64 = 20;
/// An orderly stop takes at most a second for each process.
const DOWN_PATIENCE: Duration = Duration::from_secs(15);

/// A request without a value.
pub(crate) fn plain(args: &CellArgs, action: OperatorAction) -> Result<(), Failure> {
    tell(&Session::of(&args.cell)?, &request(action), done(action))
}

/// What an accepted request did.
fn done(action: OperatorAction) -> &'static str {
    match action {
        OperatorAction::Pause => "paused",
        OperatorAction::Resume => "resumed",
        OperatorAction::Reset => "scene reset",
        OperatorAction::TaskStart => "start event given to the task",
        OperatorAction::TaskPause => "task paused",
        OperatorAction::TaskResume => "task resumed",
        OperatorAction::TaskReset => "task reset",
        _ => "accepted",
    }
}

/// `robocell step N`: returns when the ticks are done.
pub(crate) fn step(args: &StepArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Step);
    wish.count = args.ticks;
    let session = Session::of(&args.cell.cell)?;
    let bus = session.join()?;
    // From the answer: ticks that are left of an earlier step are run as well.
    let until = ask_physics(&bus, &wish)?.until_tick;
    let stopped = |state: &WorldState| {
        let is_done = state.header.tick >= until;
        // A pause during the step cancels the ticks that are left, so `until` would never be
        // reached.
        let is_paused = state.panel.pause_cause == PauseCause::Operator.code();
        (is_done || is_paused).then_some(*state)
    };
    let state = Follower::new(&session, &bus)?.until(stopped)?;
    let reached = format!("tick {} ({:.3} s)", state.header.tick, seconds(&state));
    if state.header.tick < until {
        return Err(Failure::configuration(format!(
            "paused at {reached}, before tick {until} was reached"
        )));
    }
    say::line(format_args!("stepped to {reached}"));
    Ok(())
}

/// `robocell speed 1|max|X`.
pub(crate) fn speed(args: &SpeedArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::Speed);
    wish.seconds = args.speed.factor();
    let how = match args.speed {
        Speed::RealTime => "real time".to_owned(),
        Speed::Max => "as fast as possible, in lockstep".to_owned(),
        Speed::Factor(factor) => format!("{factor} times real time, in lockstep"),
    };
    tell(
        &Session::of(&args.cell.cell)?,
        &wish,
        &format!("speed: {how},"),
    )
}

/// `robocell task VERB`.
pub(crate) fn task(args: &TaskArgs) -> Result<(), Failure> {
    let action = match args.verb {
        TaskVerb::Start => OperatorAction::TaskStart,
        TaskVerb::Pause => OperatorAction::TaskPause,
        TaskVerb::Resume => OperatorAction::TaskResume,
        TaskVerb::Reset => OperatorAction::TaskReset,
    };
    if action != OperatorAction::TaskStart {
        return plain(&args.cell, action);
    }
    let session = Session::of(&args.cell.cell)?;
    // The event is given all the same: the decision can be older than a reset of the task.
    // Without a free reader the event is given as well.
    let done = match running_phase(&session).unwrap_or_default() {
        Some(phase) => format!("the task runs already, in phase {phase}; start event given"),
        None => done(action).to_owned(),
    };
    tell(&session, &request(action), &done)
}

/// The phase of a task that runs.
fn running_phase(session: &Session) -> Result<Option<String>, Failure> {
    let mut picture = Picture::open(session)?;
    picture.fill();
    let is_running = |decision: &&Decision| decision.outcome == Outcome::Running.code();
    let running = picture.decision().filter(is_running);
    Ok(running.map(|decision| decision.phase.as_str().to_owned()))
}

/// `robocell drop-parts [N]`.
pub(crate) fn drop_parts(args: &DropPartsArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::DropParts);
    wish.count = args.count.unwrap_or(0);
    tell(&Session::of(&args.cell.cell)?, &wish, "parts dropped")
}

/// `robocell add-bin [--flipped]`.
pub(crate) fn add_bin(args: &AddBinArgs) -> Result<(), Failure> {
    let mut wish = request(OperatorAction::AddBin);
    wish.count = u32::from(args.flipped);
    tell(&Session::of(&args.cell.cell)?, &wish, "bin added")
}

/// The object with this name.
pub(super) fn object_index(cell: &Cell, object: &str) -> Result<usize, Failure> {
    let names: Vec<String> = cell.objects.iter().map(|o| o.name.clone()).collect();
    let index = names.iter().position(|name| name == object);
    index.ok_or_else(|| {
        let near = did_you_mean(object, &names);
        let known = if names.is_empty() {
            "no object".to_owned()
        } else {
            names.join(", ")
        };
        Failure::configuration(format!(
            "object `{object}` is unknown{near}; this cell has {known}"
        ))
    })
}

/// `robocell drag OBJECT --to X Y Z`: returns when the object is released.
pub(crate) fn drag(args: &DragArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let cell = session.load_cell()?;
    let index = object_index(&cell, &args.object)?;
    let mut wish = request(OperatorAction::Drag);
    // Physics refuses an index that no object has.
    wish.object = u32::try_from(index).unwrap_or(u32::MAX);
    wish.pose.position.copy_from_slice(&args.to);
    wish.seconds = args.seconds;
    let bus = session.join()?;
    let asked = ask_physics(&bus, &wish)?;
    let mut world = Follower::new(&session, &bus)?;
    let of = |state: &WorldState| state.objects().get(index).copied();
    let mut was_pulled = false;
    let released = world.until(|state| {
        let is_pulled = of(state).is_some_and(|object| object.flags & OBJECT_DRAGGED != 0);
        was_pulled |= is_pulled;
        // One that has arrived at once was never seen to be pulled.
        let is_over = was_pulled || state.header.tick > asked.header.tick + TAKES_EFFECT_TICKS;
        (state.has(FLAG_PAUSED) || (is_over && !is_pulled)).then_some(*state)
    })?;
    let [x, y, z] = of(&released).map_or([0.0; 3], |object| object.pose.position);
    let place = format!("{x:.3} {y:.3} {z:.3}");
    if released.has(FLAG_PAUSED) {
        say::line(format_args!(
            "{} is at {place}; it is pulled when simulated time is resumed",
            args.object
        ));
    } else {
        let note = match asked.message.as_str() {
            "" => String::new(),
            note => format!("; {note}"),
        };
        say::line(format_args!("{} released at {place}{note}", args.object));
    }
    Ok(())
}

pub(super) fn request(action: OperatorAction) -> OperatorRequest {
    OperatorRequest {
        action: action.code(),
        ..OperatorRequest::zeroed_at_identity()
    }
}

/// Sends `wish` to physics and prints `done` with the time and the note of the reply.
pub(super) fn tell(session: &Session, wish: &OperatorRequest, done: &str) -> Result<(), Failure> {
    let reply = ask_physics(&session.join()?, wish)?;
    let time_s = reply.header.sim_time_ns as f64 * 1.0e-9;
    let more = reply.message.as_str();
    let more = if more.is_empty() {
        String::new()
    } else {
        format!("; {more}")
    };
    say::line(format_args!("{done} at {time_s:.3} s{more}"));
    Ok(())
}

/// Hands `wish` to physics; a refusal is an error.
pub(super) fn ask_physics(bus: &Bus, wish: &OperatorRequest) -> Result<OperatorReply, Failure> {
    let mut client = bus
        .operator_client()
        .cannot("reach the operator's service")?;
    let reply = client
        .request(*wish, PATIENCE)
        .cannot("get an answer of physics")?;
    match ReplyCode::from_code(reply.code) {
        Some(ReplyCode::Accepted) => Ok(reply),
        _ => Err(Failure::configuration(format!(
            "refused: {}",
            reply.message
        ))),
    }
}

/// Simulated time of `state` (s).
fn seconds(state: &WorldState) -> f64 {
    state.header.sim_time_ns as f64 * 1.0e-9
}

/// `robocell down`: returns when nothing of the cell runs any more.
pub(crate) fn down(args: &CellArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell)?;
    say::line(accepted(ask(&session.dir.control(), &Request::Down)?)?);
    let until = Instant::now() + DOWN_PATIENCE;
    // The pid is compared, as another launcher may take the cell's name at once.
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

/// What the launcher answers; a refusal is an error.
pub(super) fn accepted(reply: Reply) -> Result<String, Failure> {
    if reply.ok {
        return Ok(reply.message);
    }
    Err(Failure::configuration(reply.message))
}
