//! Publishes the state of the bus to the pages: frames at 60 Hz while a page is open, the health
//! of all processes at 4 Hz.

use std::sync::Arc;

use cell_bus::{Bus, BusError, Latest};
use cell_worker::Start;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{ArmStatus, Contacts, Decision, Health, WorldState};
use serde_json::Value;

use crate::feed::breakpoints::BreakpointCounts;
use crate::feed::broadcast::{Broadcast, RecordedSpan};
use crate::feed::by_hand::ByHand;
use crate::feed::missed_cycles::MissedCycles;
use crate::feed::real_time_factor::RealTimeFactor;
use crate::feed::scene;
use crate::feed::scene_reset::SceneReset;
use crate::feed::snapshot::{FLAG_RECORDING, Snapshot, encode};
use crate::feed::status::{StatusInput, speed_text, status};
use crate::replay::clock::TICK_S;
use crate::timeline::lanes::{self, LaneState};
use crate::timeline::restarts::{Restart, Restarts};

/// Period of the frames: 60 a second.
// What a screen shows; more would cost the core that the loops share.
const FRAME_NS: u64 = 16_666_667;
/// Interval of the status messages.
// As fast as a person reads figures.
const STATUS_NS: u64 = 250_000_000;
/// A process that publishes nothing for this time is silent.
// A hundred health messages: a shorter limit would call a starved process silent.
const SILENCE_NS: u64 = 1_000_000_000;

/// Reads the topics that the page shows, and sends them to the broadcast.
pub struct Publisher {
    broadcast: Arc<Broadcast>,
    world: Latest<WorldState>,
    status: Vec<Latest<ArmStatus>>,
    decision: Latest<Decision>,
    contacts: Latest<Contacts>,
    /// Whether the excess of contacts over a message's capacity was reported.
    contacts_exceeded: bool,
    healths: Vec<(Process, Latest<Health>)>,
    missed_cycles: MissedCycles,
    real_time_factor: RealTimeFactor,
    fingers: Vec<usize>,
    objects: Vec<String>,
    policy: String,
    restarts: Restarts,
    breakpoints: BreakpointCounts,
    by_hand: ByHand,
    arms: Vec<String>,
    file: String,
    gaps: u64,
    scene_reset: SceneReset,
    recording: bool,
    next_frame_ns: u64,
    next_status_ns: u64,
}

impl Publisher {
    /// Opens the topics.
    ///
    /// # Errors
    ///
    /// When one cannot be opened.
    pub fn new(bus: &Bus, start: &Start, broadcast: Arc<Broadcast>) -> Result<Self, BusError> {
        let mut healths = Vec::new();
        for process in Process::all(start.spec.arms) {
            healths.push((process, bus.latest(TopicId::Health(process))?));
        }
        let arms = 0..start.spec.arms;
        let status = arms.map(|arm| bus.latest(TopicId::ArmStatus(arm)));
        Ok(Self {
            broadcast,
            world: bus.latest(TopicId::WorldState)?,
            status: status.collect::<Result<_, _>>()?,
            decision: bus.latest(TopicId::Decision)?,
            contacts: bus.latest(TopicId::Contacts)?,
            contacts_exceeded: false,
            healths,
            missed_cycles: MissedCycles::default(),
            real_time_factor: RealTimeFactor::default(),
            fingers: scene::fingers(&start.cell),
            objects: start.cell.objects.iter().map(|o| o.name.clone()).collect(),
            policy: start.spec.policy.clone(),
            restarts: Restarts::default(),
            breakpoints: BreakpointCounts::default(),
            by_hand: ByHand::new(&start.cell),
            arms: start.cell.arms.iter().map(|a| a.name.clone()).collect(),
            file: String::new(),
            gaps: 0,
            scene_reset: SceneReset::default(),
            recording: false,
            next_frame_ns: 0,
            next_status_ns: 0,
        })
    }

    /// The broadcast to all pages.
    pub fn broadcast(&self) -> &Broadcast {
        &self.broadcast
    }

    /// Time until the next task (ns).
    pub fn idle_ns(&self, now_ns: u64) -> u64 {
        // Without a page no frames: the monitor then costs four messages a second.
        let next = if self.broadcast.has_subscribers() {
            self.next_frame_ns
        } else {
            self.next_status_ns
        };
        next.saturating_sub(now_ns)
    }

    /// Makes a frame and a status message due.
    pub fn set_due(&mut self) {
        (self.next_frame_ns, self.next_status_ns) = (0, 0);
    }

    /// The last world that was read.
    pub fn world(&self) -> Option<&WorldState> {
        self.world.get()
    }

    /// Sends everything that is due at `now_ns`; returns the new lines of the log.
    pub fn update(&mut self, now_ns: u64, recorder: impl FnOnce() -> RecorderUpdate) -> Vec<Value> {
        if !self.broadcast.has_subscribers() {
            self.broadcast.forget_frame();
        } else if now_ns >= self.next_frame_ns {
            self.next_frame_ns = after(self.next_frame_ns, FRAME_NS, now_ns);
            self.frame(now_ns);
        }
        // Every turn, not every frame: a short phase must not be
        // missed between two status messages.
        self.update_timeline();
        let lines = self.broadcast.publish_trace();
        if now_ns >= self.next_status_ns {
            self.next_status_ns = after(self.next_status_ns, STATUS_NS, now_ns);
            self.publish_status(now_ns, recorder());
        }
        lines
    }

    fn refresh(&mut self) {
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
            self.broadcast.add_log_line(time_s, "lifecycle", &text);
        }
    }

    /// Updates the lanes of the timeline.
    fn update_timeline(&mut self) {
        self.world.refresh();
        self.decision.refresh();
        let Some(world) = self.world.get() else {
            return;
        };
        let decision = self.decision.get();
        // After a reset the last decision is of the scene before, until the task decides again.
        let decision = decision.filter(|decision| self.scene_reset.is_after(Some(world), decision));
        self.breakpoints.update(world, decision);
        let lane_states = lanes::lane_states(world, decision, &self.arms, &self.objects);
        let (time_s, epoch) = time_and_epoch(world);
        self.restarts.take_time(world.header.generation, time_s);
        self.broadcast
            .change_timeline(|timeline| timeline.update(time_s, epoch, lane_states));
        for outcome in self.by_hand.update(world) {
            self.broadcast.add_hand_outcome(time_s, &outcome);
        }
    }

    fn frame(&mut self, now_ns: u64) {
        self.refresh();
        // Before the first state there is no moment to show.
        let Some(world) = self.world.get() else {
            return;
        };
        let decision = self.decision.get();
        let decision = decision.filter(|decision| self.scene_reset.is_after(Some(world), decision));
        let status: Vec<Option<&ArmStatus>> = self.status.iter().map(Latest::get).collect();
        let snapshot = Snapshot {
            world,
            status: &status,
            decision,
            contacts: self.contacts.get(),
            // Measured over frames that are shown, so it falls when frames come late.
            real_time_factor: self
                .real_time_factor
                .sample(now_ns, world.header.sim_time_ns),
            flags: if self.recording { FLAG_RECORDING } else { 0 },
        };
        self.broadcast.frame(encode(&snapshot, &self.fingers));
    }

    fn publish_status(&mut self, now_ns: u64, recorder: RecorderUpdate) {
        self.refresh();
        self.recording = recorder.to_file;
        for (_, latest) in &mut self.healths {
            latest.refresh();
        }
        let processes = recent_healths(&self.healths, now_ns);
        let world = self.world.get();
        let time_s = world.map_or(0.0, |w| w.header.sim_time_ns as f64 * 1.0e-9);
        let missed = self.missed_cycles.update(&processes, time_s, now_ns);
        for restart in self.restarts.update(&processes, time_s) {
            publish_restart(&self.broadcast, &restart, world);
        }
        if let Some(world) = world {
            self.broadcast.keep_world(world);
            let gaps = recorder.gaps();
            // The number only grows, so any growth is a new gap.
            let has_gap = std::mem::replace(&mut self.gaps, gaps) < gaps;
            recorder.file().clone_into(&mut self.file);
            let mut lane_states = process_states(&self.healths, now_ns);
            lane_states.push(LaneState::recording(&self.file, has_gap));
            let (time_s, epoch) = time_and_epoch(world);
            self.broadcast
                .change_timeline(|timeline| timeline.update(time_s, epoch, lane_states));
            self.broadcast.set_speed(&speed_text(world.panel.speed));
        }
        let decision = self.decision.get();
        let decision = decision.filter(|decision| self.scene_reset.is_after(world, decision));
        let mut message = status(&StatusInput {
            processes: &processes,
            missed: &missed,
            world,
            decision,
            objects: &self.objects,
            breaks: self.breakpoints.counts(),
            policy: &self.policy,
        });
        // Replaces the message's default of a recorder that is off.
        if let Some((recorder, latency)) = recorder.status_parts {
            message["recorder"] = recorder;
            message["latency"] = latency;
        }
        // The task may have been restarted with another policy.
        if let Some(decision) = decision.filter(|d| !d.policy.is_empty()) {
            self.broadcast.set_policy(decision.policy.as_str());
        }
        self.broadcast.publish_status(&message);
        if let Some(recorded_span) = &recorder.recorded_span {
            self.broadcast.publish_recorded_span(recorded_span);
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
fn publish_restart(broadcast: &Broadcast, restart: &Restart, world: Option<&WorldState>) {
    let epoch = world.map(|world| world.header.generation);
    let time_s = world.map_or(0.0, |world| time_and_epoch(world).0);
    let resumed_s = world.map_or(0.0, |world| world.resumed_tick as f64 * TICK_S);
    // Its last message may have a later simulated time:
    // physics resumed from a saved state since.
    let (process, down_s) = (restart.process, restart.down_s.min(time_s));
    broadcast.change_timeline(|timeline| timeline.add_downtime(process, epoch, down_s, time_s));
    if let Some(text) = restart.line(resumed_s) {
        broadcast.add_restart(time_s, &text);
    }
}

/// A lane for each process; one without a health message is about to start.
fn process_states(healths: &[(Process, Latest<Health>)], now_ns: u64) -> Vec<LaneState> {
    let state = |(process, latest): &(Process, Latest<Health>)| {
        let is_silent = latest
            .get()
            .is_some_and(|health| !is_recent(health, now_ns));
        LaneState::process(*process, if is_silent { "silent" } else { "" })
    };
    healths.iter().map(state).collect()
}

/// Whether a process published `health` less than [`SILENCE_NS`] ago.
fn is_recent(health: &Health, now_ns: u64) -> bool {
    health.header.publish_ns + SILENCE_NS > now_ns
}

/// State of the recorder for a status message.
#[derive(Clone, Debug, Default)]
pub struct RecorderUpdate {
    /// `recorder` and `latency` of the message.
    pub status_parts: Option<(Value, Value)>,
    /// Content of the flight recorder, when due.
    pub recorded_span: Option<RecordedSpan>,
    /// Whether a file is being written.
    pub to_file: bool,
}

impl RecorderUpdate {
    /// Name of the file being written; empty for none.
    fn file(&self) -> &str {
        let file = self
            .status_parts
            .as_ref()
            .and_then(|(status, _)| status["file"].as_str());
        file.unwrap_or_default()
    }

    /// Number of messages lost so far.
    fn gaps(&self) -> u64 {
        let gaps = self
            .status_parts
            .as_ref()
            .and_then(|(status, _)| status["gaps"].as_u64());
        gaps.unwrap_or_default()
    }
}

/// Simulated time (s) and generation of physics of `world`.
fn time_and_epoch(world: &WorldState) -> (f64, Option<u32>) {
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
