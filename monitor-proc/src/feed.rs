//! From the bus to the hub: frames at 60 Hz while a page is open, the health of all processes
//! at 4 Hz.

use std::sync::Arc;

use cell_bus::{Bus, BusError, Latest};
use cell_worker::Start;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmStatus, Contacts, Decision, Health, WorldState};
use serde_json::Value;

use crate::breaks::Breaks;
use crate::hub::{Hub, Timeline};
use crate::lanes::{self, Row};
use crate::misses::Misses;
use crate::pace::Pace;
use crate::reset::Reset;
use crate::scene;
use crate::snapshot::{FLAG_RECORDING, Moment, encode};
use crate::starts::{Started, Starts};
use crate::status::{StatusInput, speed_text, status};

/// Period of the frames: 60 a second.
// What a screen shows; more would cost the core that the loops share.
const FRAME_NS: u64 = 16_666_667;
/// Interval of the status messages.
// As fast as a person reads figures.
const STATUS_NS: u64 = 250_000_000;
/// A process that publishes nothing for this time is silent.
// A hundred health messages: a shorter limit would call a starved process silent.
const SILENCE_NS: u64 = 1_000_000_000;

/// Reads what the page shows.
pub struct Feed {
    hub: Arc<Hub>,
    world: Latest<WorldState>,
    status: Vec<Latest<ArmStatus>>,
    decision: Latest<Decision>,
    contacts: Latest<Contacts>,
    /// Whether the excess of contacts over a message's capacity was reported.
    contacts_exceeded: bool,
    healths: Vec<(Process, Latest<Health>)>,
    misses: Misses,
    pace: Pace,
    fingers: Vec<usize>,
    objects: Vec<String>,
    policy: String,
    starts: Starts,
    breaks: Breaks,
    arms: Vec<String>,
    file: String,
    gaps: u64,
    reset: Reset,
    recording: bool,
    next_frame_ns: u64,
    next_status_ns: u64,
}

impl Feed {
    /// Opens the topics.
    ///
    /// # Errors
    ///
    /// When one cannot be opened.
    pub fn new(bus: &Bus, start: &Start, hub: Arc<Hub>) -> Result<Self, BusError> {
        let mut healths = Vec::new();
        for process in Process::all(start.spec.arms) {
            healths.push((process, bus.latest(TopicId::Health(process))?));
        }
        let arms = 0..start.spec.arms;
        let status = arms.map(|arm| bus.latest(TopicId::ArmStatus(arm)));
        Ok(Self {
            hub,
            world: bus.latest(TopicId::WorldState)?,
            status: status.collect::<Result<_, _>>()?,
            decision: bus.latest(TopicId::Decision)?,
            contacts: bus.latest(TopicId::Contacts)?,
            contacts_exceeded: false,
            healths,
            misses: Misses::default(),
            pace: Pace::default(),
            fingers: scene::fingers(&start.cell),
            objects: start.cell.objects.iter().map(|o| o.name.clone()).collect(),
            policy: start.spec.policy.clone(),
            starts: Starts::default(),
            breaks: Breaks::default(),
            arms: start.cell.arms.iter().map(|a| a.name.clone()).collect(),
            file: String::new(),
            gaps: 0,
            reset: Reset::default(),
            recording: false,
            next_frame_ns: 0,
            next_status_ns: 0,
        })
    }

    /// The hub.
    pub fn hub(&self) -> &Hub {
        &self.hub
    }

    /// Time until the next task (ns).
    pub fn idle_ns(&self, now_ns: u64) -> u64 {
        // Without a page no frames: the monitor then costs four messages a second.
        let next = if self.hub.is_watched() {
            self.next_frame_ns
        } else {
            self.next_status_ns
        };
        next.saturating_sub(now_ns)
    }

    /// The last world that was read.
    pub fn world(&self) -> Option<&WorldState> {
        self.world.get()
    }

    /// Sends everything that is due at `now_ns`; returns the new lines of the log.
    pub fn turn(&mut self, now_ns: u64, recorder: impl FnOnce() -> RecorderNews) -> Vec<Value> {
        if self.hub.is_watched() && now_ns >= self.next_frame_ns {
            self.next_frame_ns = after(self.next_frame_ns, FRAME_NS, now_ns);
            self.frame(now_ns);
        }
        // Every turn, not every frame: a short phase must not be
        // missed between two status messages.
        self.look_lanes();
        let lines = self.hub.tell_news();
        if now_ns >= self.next_status_ns {
            self.next_status_ns = after(self.next_status_ns, STATUS_NS, now_ns);
            self.tell_status(now_ns, recorder());
        }
        lines
    }

    fn look(&mut self) {
        self.world.refresh();
        self.decision.refresh();
        if self.contacts.refresh() {
            self.report_contacts();
        }
        for status in &mut self.status {
            status.refresh();
        }
    }

    /// Reports once that there are more contacts than a message carries.
    fn report_contacts(&mut self) {
        let Some(contacts) = self.contacts.get().filter(|c| c.total > c.count) else {
            return;
        };
        if !std::mem::replace(&mut self.contacts_exceeded, true) {
            let time_s = contacts.header.sim_time_ns as f64 * 1.0e-9;
            let text = format!(
                "[physics] {} contacts: the {} with the largest forces are shown",
                contacts.total, contacts.count
            );
            self.hub.say(time_s, "lifecycle", &text);
        }
    }

    /// Updates the lanes of the timeline.
    fn look_lanes(&mut self) {
        self.world.refresh();
        self.decision.refresh();
        let Some(world) = self.world.get() else {
            return;
        };
        let decision = self.decision.get();
        // After a reset the last decision is of the scene before, until the task decides again.
        let decision = decision.filter(|decision| self.reset.is_after(Some(world), decision));
        self.breaks.look(world, decision);
        let rows = lanes::rows(world, decision, &self.arms, &self.objects);
        let (time_s, epoch) = moment(world);
        self.hub
            .change_lanes(|lanes| lanes.look(time_s, epoch, rows));
    }

    fn frame(&mut self, now_ns: u64) {
        self.look();
        // Before the first state there is no moment to show.
        let Some(world) = self.world.get() else {
            return;
        };
        let decision = self.decision.get();
        let decision = decision.filter(|decision| self.reset.is_after(Some(world), decision));
        let status: Vec<Option<&ArmStatus>> = self.status.iter().map(Latest::get).collect();
        let moment = Moment {
            world,
            status: &status,
            decision,
            contacts: self.contacts.get(),
            // Measured over frames that are shown, so it falls when frames come late.
            real_time_factor: self.pace.look(now_ns, world.header.sim_time_ns),
            flags: if self.recording { FLAG_RECORDING } else { 0 },
        };
        self.hub.frame(encode(&moment, &self.fingers));
    }

    fn tell_status(&mut self, now_ns: u64, recorder: RecorderNews) {
        self.look();
        self.recording = recorder.to_file;
        for (_, latest) in &mut self.healths {
            latest.refresh();
        }
        let processes = recent_healths(&self.healths, now_ns);
        let world = self.world.get();
        let time_s = world.map_or(0.0, |w| w.header.sim_time_ns as f64 * 1.0e-9);
        let missed = self.misses.look(&processes, time_s, now_ns);
        for started in self.starts.look(&processes, time_s) {
            let epoch = world.map(|world| world.header.generation);
            tell_start(&self.hub, &started, epoch, time_s);
        }
        if let Some(world) = world {
            let gaps = recorder.gaps();
            // The number only grows, so any growth is a new gap.
            let has_gap = std::mem::replace(&mut self.gaps, gaps) < gaps;
            recorder.file().clone_into(&mut self.file);
            let mut rows = process_rows(&self.healths, now_ns);
            rows.push(Row::recording(&self.file, has_gap));
            let (time_s, epoch) = moment(world);
            self.hub
                .change_lanes(|lanes| lanes.look(time_s, epoch, rows));
            self.hub.set_speed(&speed_text(world.panel.speed));
        }
        let decision = self.decision.get();
        let decision = decision.filter(|decision| self.reset.is_after(world, decision));
        let mut message = status(&StatusInput {
            processes: &processes,
            missed: &missed,
            world,
            decision,
            objects: &self.objects,
            breaks: self.breaks.counts(),
            policy: &self.policy,
        });
        // Replaces the message's default of a recorder that is off.
        if let Some((recorder, latency)) = recorder.told {
            message["recorder"] = recorder;
            message["latency"] = latency;
        }
        // The task may have been restarted with another policy.
        if let Some(decision) = decision.filter(|d| !d.policy.is_empty()) {
            self.hub.set_policy(decision.policy.as_str());
        }
        self.hub.tell_status(&message);
        if let Some(timeline) = &recorder.timeline {
            self.hub.tell_timeline(timeline);
        }
    }
}

/// The newest health of each process; `None` for a silent one.
fn recent_healths(
    healths: &[(Process, Latest<Health>)],
    now_ns: u64,
) -> Vec<(Process, Option<&Health>)> {
    let healths = healths.iter();
    healths
        // A silent process is shown as silent, not with its last figures.
        .map(|(process, latest)| (*process, latest.get().filter(|h| is_recent(h, now_ns))))
        .collect()
}

/// Shows the start of a process on the timeline and in the log.
fn tell_start(hub: &Hub, started: &Started, epoch: Option<u32>, time_s: f64) {
    // Its last message may have a later simulated time:
    // physics resumed from a saved state since.
    let (process, down_s) = (started.process, started.down_s.min(time_s));
    hub.change_lanes(|lanes| lanes.was_down(process, epoch, down_s, time_s));
    if let Some(text) = started.line() {
        hub.restarted(time_s, &text);
    }
}

/// A lane for each process; one without a health message is about to start.
fn process_rows(healths: &[(Process, Latest<Health>)], now_ns: u64) -> Vec<Row> {
    let row = |(process, latest): &(Process, Latest<Health>)| {
        let is_silent = latest
            .get()
            .is_some_and(|health| !is_recent(health, now_ns));
        Row::process(*process, if is_silent { "silent" } else { "" })
    };
    healths.iter().map(row).collect()
}

/// Whether a process published `health` less than [`SILENCE_NS`] ago.
fn is_recent(health: &Health, now_ns: u64) -> bool {
    health.header.publish_ns + SILENCE_NS > now_ns
}

/// News of the recorder for a status.
#[derive(Clone, Debug, Default)]
pub struct RecorderNews {
    /// `recorder` and `latency` of the message.
    pub told: Option<(Value, Value)>,
    /// Content of the flight recorder, when due.
    pub timeline: Option<Timeline>,
    /// Whether a file is being written.
    pub to_file: bool,
}

impl RecorderNews {
    /// Name of the file being written; empty for none.
    fn file(&self) -> &str {
        let file = self
            .told
            .as_ref()
            .and_then(|(told, _)| told["file"].as_str());
        file.unwrap_or_default()
    }

    /// Number of messages lost so far.
    fn gaps(&self) -> u64 {
        let gaps = self
            .told
            .as_ref()
            .and_then(|(told, _)| told["gaps"].as_u64());
        gaps.unwrap_or_default()
    }
}

/// Simulated time (s) and generation of physics of `world`.
fn moment(world: &WorldState) -> (f64, Option<u32>) {
    let header = &world.header;
    (header.sim_time_ns as f64 * 1.0e-9, Some(header.generation))
}

/// The next due time of a period after `now_ns`; missed ones are skipped.
fn after(due_ns: u64, period_ns: u64, now_ns: u64) -> u64 {
    let next = due_ns + period_ns;
    // A burst of late frames would show the past.
    if next > now_ns {
        next
    } else {
        now_ns + period_ns
    }
}
