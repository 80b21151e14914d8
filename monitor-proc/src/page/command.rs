//! The commands of a page (docs/page-protocol.md), validated.
//!
//! A page is a program of anyone with the token, so no part of a command is trusted: each field
//! has a range, names must be of this cell, and file names are never taken from a page.

use cell_run::spec::Speed;
use ipc_types::operator::OperatorAction;
use ipc_types::validate::MAX_JOINT_POSITION;
use ipc_types::{BreakName, GripperGoal, MAX_JOINTS, OperatorRequest, Pose, Wire};
use serde_json::{Value, json};

use super::fields::{Fields, MAX_WHOLE};

/// Largest coordinate of a position in a command (m).
// Well beyond the reach of any arm.
const MAX_PLACE_M: f64 = 20.0;
/// Largest contact force of a target (N).
const MAX_CONTACT_N: f64 = 1000.0;
/// Longest drag (s).
const MAX_DRAG_S: f64 = 3600.0;
/// Largest number of ticks of one step.
const MAX_STEPS: u64 = 1_000_000;
/// Largest number of parts of one request.
const MAX_PARTS: u64 = 1000;
/// Longest simulated time (s).
const MAX_TIME_S: f64 = 1.0e9;

/// Names that a command can use.
#[derive(Clone, Debug, Default)]
pub struct Names {
    /// Objects in the order of the cell file.
    pub objects: Vec<String>,
    /// Arms of the cell.
    pub arms: u32,
}

/// An order to be carried out.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// By physics.
    Operate(Box<OperatorRequest>),
    /// By the launcher: one line of its protocol.
    Launch(Value),
    /// By the recorder.
    Record(RecordOrder),
    /// By the clock of a replay.
    Play(PlayOrder),
}

/// Order to the recorder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RecordOrder {
    /// Record everything from now on, in a file.
    Start,
    /// Close that file.
    Stop,
    /// Write a file of the last so many seconds.
    Last(f64),
}

/// Order to the clock of a replay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlayOrder {
    /// Go to this time (s).
    pub time_s: Option<f64>,
    /// Generation of physics whose history is meant; the newest by default.
    pub epoch: Option<u32>,
    /// Play, or pause.
    pub play: Option<bool>,
    /// Seconds of the recording per second.
    pub speed: Option<f64>,
    /// Step by so many ticks, then pause.
    pub step: Option<u64>,
}

/// A command of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// For a [`super::queue::CommandQueue`]; the text is for the log.
    Order(Order, String),
    /// Show another time to this client only; `None`: live.
    Seek(PlayOrder),
    /// Send the whole state again.
    Again,
}

/// Number of a command for its answer, 0 if it cannot be read.
pub fn id(command: &Value) -> u64 {
    command
        .get("id")
        .and_then(Value::as_u64)
        .filter(|id| *id <= MAX_WHOLE)
        // Even an invalid command gets an answer, so its number is read before the rest.
        .unwrap_or(0)
}

/// Reads one command.
///
/// # Errors
///
/// The field, its value, and the allowed values.
pub fn parse(command: &Value, names: &Names) -> Result<Command, String> {
    let Some(map) = command.as_object() else {
        return Err("a command must be an object with `id` and `do`".to_owned());
    };
    let fields = Fields(map);
    // Checked although unused here: an answer without its number is lost for the page.
    fields.whole("id", 0, MAX_WHOLE)?;
    let verb = fields.one_of("do", VERBS)?;
    match verb {
        "again" => Ok(Command::Again),
        "seek" => seek(&fields).map(Command::Seek),
        "restart" => restart(&fields),
        "load" => load(&fields),
        "record" => record(&fields),
        _ => operate(verb, &fields, names),
    }
}

// The list is in the message of an unknown verb, so it must be complete.
const VERBS: &[&str] = &[
    "pause",
    "resume",
    "reset",
    "step",
    "task_start",
    "task_pause",
    "task_resume",
    "task_reset",
    "drag",
    "target",
    "joints",
    "break",
    "speed",
    "gripper",
    "drop_parts",
    "add_bin",
    "restart",
    "load",
    "record",
    "seek",
    "again",
];

fn operate(verb: &str, fields: &Fields<'_>, names: &Names) -> Result<Command, String> {
    // All fields have a valid value from here on; the match below sets those of the action.
    let mut request = OperatorRequest::zeroed();
    request.pose = Pose::IDENTITY;
    let mut description = verb.replace('_', " ");
    let action = match verb {
        "pause" => OperatorAction::Pause,
        "resume" => OperatorAction::Resume,
        "reset" => OperatorAction::Reset,
        "task_start" => OperatorAction::TaskStart,
        "task_pause" => OperatorAction::TaskPause,
        "task_resume" => OperatorAction::TaskResume,
        "task_reset" => OperatorAction::TaskReset,
        "step" => {
            request.count = count(fields, 1, MAX_STEPS)?;
            OperatorAction::Step
        }
        "drop_parts" => {
            request.count = count(fields, 0, MAX_PARTS)?;
            OperatorAction::DropParts
        }
        "add_bin" => {
            request.count = u32::from(fields.flag("flipped")?);
            OperatorAction::AddBin
        }
        "drag" => drag(&mut request, &mut description, fields, names)?,
        "target" => target(&mut request, fields, names)?,
        "joints" => joints(&mut request, fields, names)?,
        "break" => breakpoint(&mut request, &mut description, fields)?,
        "speed" => speed(&mut request, &mut description, fields)?,
        _ => gripper(&mut request, &mut description, fields, names)?,
    };
    request.action = action.code();
    if matches!(verb, "step" | "drop_parts") {
        description = format!("{description} {}", request.count);
    }
    Ok(Command::Order(
        Order::Operate(Box::new(request)),
        description,
    ))
}

/// The field `count`; `least` if it is missing.
fn count(fields: &Fields<'_>, least: u64, most: u64) -> Result<u32, String> {
    let count = if fields.is_missing("count") {
        least
    } else {
        fields.whole("count", least, most)?
    };
    Ok(u32::try_from(count).unwrap_or(u32::MAX))
}

fn drag(
    request: &mut OperatorRequest,
    description: &mut String,
    fields: &Fields<'_>,
    names: &Names,
) -> Result<OperatorAction, String> {
    // By name: indices of objects change with the cell file, and a page may be older.
    let name = fields.text("object", "the name of an object")?;
    let index = names.objects.iter().position(|known| known == name);
    let index = index.and_then(|index| u32::try_from(index).ok());
    let known = || format!("one of {}", names.objects.join(", "));
    request.object = index.ok_or_else(|| fields.wrong("object", &known()))?;
    request.pose.position = fields.numbers("to", MAX_PLACE_M)?;
    // Two seconds, as the page repeats a drag while the hand
    // moves, and it must end without one.
    request.seconds = if fields.is_missing("for_s") {
        2.0
    } else {
        fields.number("for_s", 0.0, MAX_DRAG_S)?
    };
    *description = format!("drag {name}");
    Ok(OperatorAction::Drag)
}

fn arm(fields: &Fields<'_>, names: &Names) -> Result<u32, String> {
    if fields.is_missing("arm") {
        return Ok(0);
    }
    let last = u64::from(names.arms.saturating_sub(1));
    Ok(u32::try_from(fields.whole("arm", 0, last)?).unwrap_or(0))
}

fn target(
    request: &mut OperatorRequest,
    fields: &Fields<'_>,
    names: &Names,
) -> Result<OperatorAction, String> {
    request.arm = arm(fields, names)?;
    request.pose.position = fields.numbers("position", MAX_PLACE_M)?;
    let turn: [f64; 4] = fields.numbers("orientation_wxyz", 1.001)?;
    let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Rounded numbers of a page are accepted, then normalised: physics requires 1e-6.
    if (length - 1.0).abs() > 1.0e-3 {
        return Err(fields.wrong("orientation_wxyz", "a unit quaternion, w first"));
    }
    request.pose.orientation_wxyz = turn.map(|x| x / length);
    request.contact_limit = contact_limit(fields)?;
    Ok(OperatorAction::Target)
}

/// The field `contact_limit_n`; the limit of physics if it is missing.
fn contact_limit(fields: &Fields<'_>) -> Result<f64, String> {
    if fields.is_missing("contact_limit_n") {
        return Ok(0.0);
    }
    fields.number("contact_limit_n", 1.0, MAX_CONTACT_N)
}

fn joints(
    request: &mut OperatorRequest,
    fields: &Fields<'_>,
    names: &Names,
) -> Result<OperatorAction, String> {
    request.arm = arm(fields, names)?;
    let positions = fields.list("positions", MAX_JOINTS, MAX_JOINT_POSITION)?;
    for (slot, position) in request.joints.iter_mut().zip(positions) {
        *slot = position;
    }
    request.contact_limit = contact_limit(fields)?;
    Ok(OperatorAction::Joints)
}

fn breakpoint(
    request: &mut OperatorRequest,
    description: &mut String,
    fields: &Fields<'_>,
) -> Result<OperatorAction, String> {
    let allowed = "the name of a node, state or guard, at most 48 bytes";
    let name = fields.text("name", allowed)?;
    // A name that was cut would match nothing, or the wrong node.
    request.name = BreakName::new(name);
    if name.is_empty() || request.name.as_str() != name {
        return Err(fields.wrong("name", allowed));
    }
    let on = fields.flag("on")?;
    request.count = u32::from(on);
    *description = format!("break {}{name}", if on { "" } else { "--remove " });
    Ok(OperatorAction::Break)
}

fn speed(
    request: &mut OperatorRequest,
    description: &mut String,
    fields: &Fields<'_>,
) -> Result<OperatorAction, String> {
    let allowed = "1, max, or a factor from 0.01 to 50";
    let text = fields.text("speed", allowed)?;
    let speed = text.parse::<Speed>();
    request.seconds = speed.map_err(|_| fields.wrong("speed", allowed))?.factor();
    *description = format!("speed {text}");
    Ok(OperatorAction::Speed)
}

fn gripper(
    request: &mut OperatorRequest,
    description: &mut String,
    fields: &Fields<'_>,
    names: &Names,
) -> Result<OperatorAction, String> {
    request.arm = arm(fields, names)?;
    let word = fields.one_of("to", &["open", "close"])?;
    let goal = if word == "open" {
        GripperGoal::Open
    } else {
        GripperGoal::Close
    };
    request.count = goal.code();
    *description = format!("gripper {word}");
    Ok(OperatorAction::Gripper)
}

/// A plain name; the launcher knows which ones exist.
fn name(fields: &Fields<'_>, key: &str) -> Result<String, String> {
    let allowed = "a name of letters, digits, '-' and '_'";
    let text = fields.text(key, allowed)?;
    // No dot, slash or leading dash: the name becomes part of a path and of a command line.
    let fine = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if (1..=64).contains(&text.len()) && text.chars().all(fine) && !text.starts_with('-') {
        return Ok(text.to_owned());
    }
    Err(fields.wrong(key, allowed))
}

fn policy(fields: &Fields<'_>) -> Result<Option<String>, String> {
    if fields.is_missing("policy") {
        return Ok(None);
    }
    name(fields, "policy").map(Some)
}

fn restart(fields: &Fields<'_>) -> Result<Command, String> {
    let known = ["task", "controller", "physics", "monitor"];
    let process = fields.one_of("process", &known)?;
    let policy = policy(fields)?;
    let line = json!({ "ask": "restart", "process": process, "policy": policy });
    Ok(Command::Order(
        Order::Launch(line),
        format!("restart {process}"),
    ))
}

fn load(fields: &Fields<'_>) -> Result<Command, String> {
    let demo = name(fields, "demo")?;
    let policy = policy(fields)?;
    let seed = fields.whole("seed", 0, MAX_WHOLE)?;
    let speed = fields.text("speed", "1, max, or a factor from 0.01 to 50")?;
    speed
        .parse::<Speed>()
        .map_err(|_| fields.wrong("speed", "1, max, or a factor from 0.01 to 50"))?;
    let description = format!("load {demo}, seed {seed}, speed {speed}");
    let line = json!({
        "ask": "load", "demo": demo, "policy": policy, "seed": seed, "speed": speed,
    });
    Ok(Command::Order(Order::Launch(line), description))
}

fn record(fields: &Fields<'_>) -> Result<Command, String> {
    let what = fields.one_of("what", &["start", "stop", "last"])?;
    let order = match what {
        "start" => RecordOrder::Start,
        "stop" => RecordOrder::Stop,
        _ if fields.is_missing("seconds") => RecordOrder::Last(60.0),
        _ => RecordOrder::Last(fields.number("seconds", 0.1, 1.0e6)?),
    };
    Ok(Command::Order(
        Order::Record(order),
        format!("record {what}"),
    ))
}

fn seek(fields: &Fields<'_>) -> Result<PlayOrder, String> {
    let mut order = PlayOrder::default();
    if !fields.is_missing("time_s") {
        order.time_s = Some(fields.number("time_s", 0.0, MAX_TIME_S)?);
    }
    if !fields.is_missing("epoch") {
        let epoch = fields.whole("epoch", 0, u64::from(u32::MAX))?;
        order.epoch = u32::try_from(epoch).ok();
    }
    if !fields.is_missing("play") {
        order.play = Some(fields.flag("play")?);
    }
    if !fields.is_missing("speed") {
        order.speed = Some(fields.number("speed", 0.01, 50.0)?);
    }
    Ok(order)
}
