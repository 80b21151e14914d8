//! The screen of a cell of another host, from the monitor that serves its page
//! (docs/page-protocol.md).

mod connect;
mod frame;

use std::net::TcpStream;
use std::time::{Duration, Instant};

use behavior::NodeStatus;
use behavior::graph::Graph;
use serde::Deserialize;
use serde_json::Value;
use tungstenite::{Message, WebSocket};

use self::connect::Address;
use self::frame::{ArmFrame, Snapshot};
use super::screen::{ArmText, Screen};
use crate::client::status::{ProcessStatus, pace, waits_for};
use crate::client::watched::{Trace, Watched};
use crate::failure::{Context as _, Failure};

/// What a monitor has told.
pub(super) struct Remote {
    socket: WebSocket<TcpStream>,
    address: Address,
    run: Run,
    role: String,
    names: Names,
    status: Status,
    trace: Trace,
    snapshot: Option<Snapshot>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Run {
    cell: String,
    demo: String,
    seed: u64,
}

/// Of the scene.
#[derive(Default)]
struct Names {
    objects: Vec<String>,
    sensors: Vec<String>,
    /// By arm: `parallel`, `suction`, or empty.
    grippers: Vec<String>,
    has_belt: bool,
    has_dispenser: bool,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Status {
    processes: Vec<ProcessTold>,
    task: Task,
    pause_detail: String,
    equipment: Option<Equipment>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct ProcessTold {
    name: String,
    pid: Option<u32>,
    generation: Option<u32>,
    scheduling: Option<String>,
    rate_hz: f64,
    late_p50_us: f64,
    late_p99_us: f64,
    missed: u64,
    rejected: u64,
    note: String,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Task {
    policy: String,
    outcome: String,
    phase: String,
    reason: String,
    placed: Vec<String>,
    drops: u32,
    resyncs: u32,
    aborts: u32,
    limit_violations: u64,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Equipment {
    conveyor_speed_m_s: f64,
    bins_supplied: u32,
    supply_refusals: u32,
    parts_dropped: u32,
    parts_waiting: u32,
    sensors: Vec<Option<String>>,
}

impl Remote {
    /// Connects to the page at `url`, with the token in it.
    pub(super) fn open(url: &str) -> Result<Self, Failure> {
        let address = Address::of(url)?;
        Ok(Self {
            socket: address.connect()?,
            address,
            run: Run::default(),
            role: String::new(),
            names: Names::default(),
            status: Status::default(),
            trace: Trace::default(),
            snapshot: None,
        })
    }

    /// Takes what arrives within `time`.
    pub(super) fn update(&mut self, time: Duration) -> Result<(), Failure> {
        let until = Instant::now() + time;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            let timeout = self.socket.get_ref().set_read_timeout(Some(left));
            timeout.cannot("read from the monitor")?;
            match self.socket.read() {
                Ok(Message::Text(text)) => self.told(&text)?,
                Ok(Message::Binary(bytes)) => {
                    self.snapshot = Snapshot::of(&bytes).or(self.snapshot.take());
                }
                Ok(Message::Close(_)) => {
                    return Err(self.address.gone("the connection was closed"));
                }
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if connect::is_no_end(error.kind()) => {}
                Err(error) => return Err(self.address.gone(error)),
            }
        }
    }

    /// Whether all was heard that a frame shows.
    pub(super) fn is_complete(&self) -> bool {
        self.snapshot.is_some() && !self.status.processes.is_empty()
    }

    /// One message; what is not known is left out.
    fn told(&mut self, text: &str) -> Result<(), Failure> {
        let Ok(mut message) = serde_json::from_str::<Value>(text) else {
            return Ok(());
        };
        let field = |message: &mut Value, name: &str| message.get_mut(name).map(Value::take);
        let kind = field(&mut message, "t").unwrap_or_default();
        match kind.as_str() {
            Some("hello") => {
                self.run = parsed(field(&mut message, "run"));
                self.role = parsed(field(&mut message, "role"));
            }
            Some("scene") => self.names = Names::of(message.get("scene").unwrap_or(&message)),
            Some("status") => self.status = parsed(Some(message)),
            Some("graphs") => {
                let graphs: Vec<Graph> = parsed(field(&mut message, "graphs"));
                self.trace.pictures = graphs.into_iter().map(Watched::new).collect();
            }
            Some("statuses") => {
                let graph: usize = parsed(field(&mut message, "graph"));
                let letters: String = parsed(field(&mut message, "letters"));
                if let Some(picture) = self.trace.pictures.get_mut(graph) {
                    let status = |letter| NodeStatus::from_letter(letter).unwrap_or_default();
                    picture.statuses = letters.chars().map(status).collect();
                }
            }
            Some("log") => {
                if parsed(field(&mut message, "all")) {
                    self.trace.log.clear();
                }
                let lines: Vec<Line> = parsed(field(&mut message, "lines"));
                for line in lines {
                    self.trace.say(line.time_s, line.text);
                }
            }
            Some("gone") => {
                let what: String = parsed(field(&mut message, "what"));
                return Err(self
                    .address
                    .gone(format_args!("the monitor closes it: {what}")));
            }
            _ => {}
        }
        Ok(())
    }

    /// What is shown now.
    pub(super) fn screen(&self) -> Screen {
        let arms = self.snapshot.iter().flat_map(|snapshot| &snapshot.arms);
        let arms = arms.enumerate();
        let equipment = self.status.equipment.as_ref();
        Screen {
            title: self.title(),
            task: self.status.task.text(),
            active: self.trace.active(),
            processes: self
                .status
                .processes
                .iter()
                .map(ProcessTold::status)
                .collect(),
            arms: arms
                .flat_map(|(index, arm)| self.names.arm_lines(index, arm))
                .collect(),
            equipment: equipment.map_or_else(Vec::new, |told| self.names.lines(told)),
            log: self.trace.log.iter().cloned().collect(),
        }
    }

    fn title(&self) -> String {
        let (run, snapshot) = (&self.run, self.snapshot.as_ref());
        let time = snapshot.map_or_else(
            || "no state".to_owned(),
            |s| format!("{:.2} s{}", s.time_s, pace(Some(s.real_time_factor))),
        );
        let pause = match self.status.pause_detail.as_str() {
            _ if !snapshot.is_some_and(|s| s.is_paused) => String::new(),
            "" => "  PAUSED".to_owned(),
            name => format!("  PAUSED by breakpoint {name}"),
        };
        format!(
            "{}  cell `{}` at {}  seed {}  {time}{pause}  {}  (q quits)",
            run.demo, run.cell, self.address, run.seed, self.role
        )
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Line {
    time_s: f64,
    text: String,
}

/// A value of a message, or what stands for one that is missing or of another kind.
fn parsed<T: Default + for<'a> Deserialize<'a>>(value: Option<Value>) -> T {
    let value = value.map(serde_json::from_value);
    value.and_then(Result::ok).unwrap_or_default()
}

impl ProcessTold {
    fn status(&self) -> ProcessStatus {
        // A process that is silent has no pid, and no figures.
        let runs = self.pid.is_some();
        let scheduling = match self.scheduling.as_deref() {
            Some("fifo") => Some("fifo"),
            Some(_) => Some("other"),
            None => None,
        };
        ProcessStatus {
            name: self.name.clone(),
            pid: self.pid,
            generation: self.generation,
            scheduling,
            rate_hz: runs.then_some(self.rate_hz),
            late_p50_us: runs.then_some(self.late_p50_us),
            late_p99_us: runs.then_some(self.late_p99_us),
            missed_cycles: runs.then_some(self.missed),
            refused: runs.then_some(self.rejected),
            note: Some(self.note.clone()).filter(|note| !note.is_empty()),
        }
    }
}

impl Task {
    fn text(&self) -> String {
        let waits = waits_for(&self.outcome);
        format!(
            "{}: {}{waits} {}  phase {}  placed {}  drops {}  resyncs {}  aborts {}  limit violations {}",
            self.policy,
            self.outcome,
            self.reason,
            self.phase,
            self.placed.len(),
            self.drops,
            self.resyncs,
            self.aborts,
            self.limit_violations,
        )
    }
}

impl Names {
    fn of(scene: &Value) -> Self {
        let list = |key: &str| scene[key].as_array().into_iter().flatten();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        Self {
            objects: list("objects")
                .map(|object| text(&object["name"]))
                .collect(),
            sensors: list("sensors")
                .map(|sensor| text(&sensor["name"]))
                .collect(),
            grippers: list("arms")
                .map(|arm| text(&arm["gripper"]["kind"]))
                .collect(),
            has_belt: !scene["conveyor"].is_null(),
            has_dispenser: !scene["dispenser"].is_null(),
        }
    }

    fn arm_lines(&self, index: usize, arm: &ArmFrame) -> [String; 4] {
        let held = arm
            .held_object
            .checked_sub(1)
            .and_then(|held| self.objects.get(held));
        let held = held.map_or("nothing", String::as_str);
        let gripper = match self.grippers.get(index).map(String::as_str) {
            Some("suction") => format!("suction load {:.0} %, holds {held}", 100.0 * arm.load),
            Some("parallel") => format!(
                "gripper {:.1} mm {:.1} N, holds {held}",
                1e3 * arm.width_m,
                arm.grip_force
            ),
            _ => "no gripper".to_owned(),
        };
        let arm = ArmText {
            index,
            joint_positions: &arm.joint_positions,
            joint_efforts: &arm.joint_efforts,
            tcp: arm.tcp,
            more: String::new(),
            gripper,
        };
        arm.lines()
    }

    fn lines(&self, told: &Equipment) -> Vec<String> {
        let mut lines = Vec::new();
        if self.has_belt {
            let (speed, bins) = (told.conveyor_speed_m_s, told.bins_supplied);
            let refused = told.supply_refusals;
            lines.push(format!(
                "belt       {speed:.2} m/s; bins: {bins} came, {refused} refused"
            ));
        }
        if self.has_dispenser {
            let (dropped, waiting) = (told.parts_dropped, told.parts_waiting);
            lines.push(format!(
                "dispenser  {dropped} parts dropped, {waiting} still to fall"
            ));
        }
        let pairs = self.sensors.iter().zip(&told.sensors);
        let state = |(name, object): (&String, &Option<String>)| {
            format!("{name} {}", object.as_deref().unwrap_or("free"))
        };
        let sensors: Vec<String> = pairs.map(state).collect();
        if !sensors.is_empty() {
            lines.push(format!("sensors    {}", sensors.join(", ")));
        }
        lines
    }
}
