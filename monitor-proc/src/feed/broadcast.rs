//! Broadcasts frames and messages to pages: the newest frame, and messages with the last state
//! for late subscribers. The source is the bus, a replayed file, or a test.
//!
//! Sending never waits for a page: frames are replaced, and messages beyond the buffer are
//! replaced by the whole state. `subscribe` and every `publish` hold one lock, so that a page
//! gets each message exactly once, in its state or as a change.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use cell_record::EpochSpan;
use cell_run::incident::Head;
use ipc_types::trace::TraceEvent;
use ipc_types::{TraceLine, WorldState};
use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::{broadcast, watch};

use crate::feed::by_hand::Outcome;
use crate::feed::hello::Hello;
use crate::page::role::Role;
use crate::timeline::lanes::{LaneSpan, Timeline};
use crate::trace::TraceModel;
use crate::trace::history::TraceHistory;

/// Messages that a slow reader can be behind; then everything is sent again.
// Bounds memory: a page that is further behind gets the whole state instead.
const WAITING_MESSAGES: usize = 512;

/// Simulated time that the recorder holds: the message `timeline`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RecordedSpan {
    /// First time of the newest epoch's history (s).
    pub from_s: f64,
    /// Last time of it (s).
    pub to_s: f64,
    /// Every epoch, oldest first: generations of physics.
    pub epochs: Vec<EpochSpan>,
}

/// Last state of everything that is sent to pages.
struct LastState {
    hello: Hello,
    scene: Arc<Value>,
    trace: TraceModel,
    trace_history: TraceHistory,
    timeline: Timeline,
    marks: Option<Utf8Bytes>,
    status: Option<Utf8Bytes>,
    recorded_span: Option<Utf8Bytes>,
    world: Option<Box<WorldState>>,
}

/// Receivers of one client.
pub struct Subscription {
    /// The newest frame; empty before the first.
    pub frames: watch::Receiver<Bytes>,
    /// Messages from now on.
    pub messages: broadcast::Receiver<Utf8Bytes>,
    /// Reason why the connection has to end, once it has to.
    pub close_reason: watch::Receiver<Option<&'static str>>,
    /// Everything sent before.
    pub state: Vec<Utf8Bytes>,
}

/// Sends to all pages; never blocks.
pub struct Broadcast {
    frames: watch::Sender<Bytes>,
    messages: broadcast::Sender<Utf8Bytes>,
    close_reason: watch::Sender<Option<&'static str>>,
    last: Mutex<LastState>,
}

impl Broadcast {
    /// A broadcast whose only state is the scene.
    pub fn new(hello: Hello, scene: Value) -> Arc<Self> {
        let last = LastState {
            hello,
            scene: Arc::new(scene),
            trace: TraceModel::default(),
            trace_history: TraceHistory::default(),
            timeline: Timeline::default(),
            marks: None,
            status: None,
            recorded_span: None,
            world: None,
        };
        Arc::new(Self {
            frames: watch::Sender::new(Bytes::new()),
            messages: broadcast::Sender::new(WAITING_MESSAGES),
            close_reason: watch::Sender::new(None),
            last: Mutex::new(last),
        })
    }

    /// Whether a page is connected.
    pub fn has_subscribers(&self) -> bool {
        self.frames.receiver_count() > 0
    }

    /// Shows a frame; the one before is dropped, seen or not. A frame equal to the one before
    /// is not sent.
    pub fn frame(&self, frame: Vec<u8>) {
        // A paused cell sends nothing: the page would draw the same again.
        self.frames.send_if_modified(|newest| {
            let new = *newest != frame;
            if new {
                *newest = Bytes::from(frame);
            }
            new
        });
    }

    /// Drops the newest frame: while no page is connected none is made, and a page that joins
    /// later must not be shown an old one.
    pub fn forget_frame(&self) {
        self.frames.send_if_modified(|newest| {
            let had_one = !newest.is_empty();
            *newest = Bytes::new();
            had_one
        });
    }

    /// Keeps a state of the world for requests about it.
    pub fn keep_world(&self, world: &WorldState) {
        let mut last = self.lock();
        match &mut last.world {
            Some(kept) => kept.copy_from(world),
            none => *none = Some(Box::new(*world)),
        }
    }

    /// The state of the world that was kept last.
    pub fn world(&self) -> Option<Box<WorldState>> {
        self.lock().world.clone()
    }

    /// Sets the epoch, a generation of physics, of all that follows.
    pub fn set_epoch(&self, epoch: u32) {
        self.lock().trace.set_epoch(epoch);
    }

    /// Takes a line of the task's trace; [`Self::publish_trace`] sends it.
    pub fn take_line(&self, line: &TraceLine) {
        let mut last = self.lock();
        let last = &mut *last;
        let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
        // The history before the line: it keeps the state before this time.
        last.trace_history.next(time_s, &last.trace);
        last.trace.take(line);
    }

    /// Statuses of the task's pictures some seconds before `time_s`, with that time; none if no
    /// page was served then.
    pub fn trace_before(&self, time_s: f64) -> Option<(f64, TraceModel)> {
        self.lock().trace_history.before(time_s)
    }

    /// Adds a line without an event to the log.
    pub fn add_log_line(&self, time_s: f64, kind: &str, text: &str) {
        self.add_event(time_s, kind, TraceEvent::None, text);
    }

    /// Adds a line about a process that was restarted to the log.
    pub fn add_restart(&self, time_s: f64, text: &str) {
        self.add_event(time_s, "lifecycle", TraceEvent::Restart, text);
    }

    /// Adds lines of the channel `page` of a recording.
    pub fn add_recorded(&self, lines: impl IntoIterator<Item = Value>) {
        let trace = &mut self.lock().trace;
        lines.into_iter().for_each(|line| trace.add_recorded(line));
    }

    /// Adds the outcome of a request to an arm that is led by hand to the log.
    pub fn add_hand_outcome(&self, time_s: f64, outcome: &Outcome) {
        let event = if outcome.is_good {
            TraceEvent::Hand
        } else {
            TraceEvent::HandFailed
        };
        let text = format!("operator: {}", outcome.text);
        self.add_event(time_s, "lifecycle", event, &text);
    }

    /// Adds a warning about the inputs of the run to the log.
    pub fn warn(&self, text: &str) {
        self.add_log_line(0.0, "lifecycle", &format!("[warning] {text}"));
    }

    fn add_event(&self, time_s: f64, kind: &str, event: TraceEvent, text: &str) {
        let trace = &mut self.lock().trace;
        trace.add_log_line(time_s, kind, event, text);
    }

    /// Adds an incident to the log, and the reason to the lane of the process.
    pub fn add_incident(&self, head: &Head, what: &str) {
        let mut last = self.lock();
        last.trace.add_incident(head, what);
        last.timeline.explain(head.sim_time_s, what);
    }

    /// Lines of the log since the last call that are not of the task's trace.
    pub fn take_own_lines(&self) -> Vec<Value> {
        self.lock().trace.take_own_lines()
    }

    /// Changes the lanes of the timeline; [`Self::publish_timeline`] sends the changes.
    pub fn change_timeline(&self, change: impl FnOnce(&mut Timeline)) {
        change(&mut self.lock().timeline);
    }

    /// Sends the changes of the timeline's lanes and returns them.
    pub fn publish_timeline(&self) -> Vec<LaneSpan> {
        let mut last = self.lock();
        let changes = last.timeline.take_changes();
        if !changes.is_empty() {
            self.publish(&last.timeline.message(Some(&changes)));
        }
        changes
    }

    /// Shows another timeline, with `marks`: lines of the log.
    pub fn replace_timeline(&self, timeline: Timeline, marks: &[Value]) {
        let mut last = self.lock();
        last.timeline = timeline;
        // Sent as a whole below, so they are not changes.
        last.timeline.take_changes();
        self.publish(&last.timeline.message(None));
        last.marks = Some(self.publish(&json!({ "t": "marks", "lines": marks })));
    }

    /// Replaces the task's trace: another time is shown from now on.
    pub fn replace_trace(&self, trace: TraceModel) {
        let mut last = self.lock();
        last.trace = trace;
        self.publish(&json!({ "t": "now" }));
        for message in last.trace.full_state() {
            self.publish(&message);
        }
        // Its changes are part of the state just sent.
        last.trace.take_changes();
    }

    /// Adds lines that an earlier start of the monitor sent.
    pub fn restore_log(&self, lines: Vec<Value>) {
        self.lock().trace.restore_log(lines);
    }

    /// Sends the changes of the task's trace; returns its new lines of the log.
    pub fn publish_trace(&self) -> Vec<Value> {
        let mut last = self.lock();
        let mut lines = Vec::new();
        for message in last.trace.take_changes() {
            self.publish(&message);
            if let Some(new) = message["lines"].as_array() {
                lines.extend(new.iter().cloned());
            }
        }
        lines
    }

    /// Sends the health of all processes.
    pub fn publish_status(&self, status: &Value) {
        let mut last = self.lock();
        last.status = Some(self.publish(status));
    }

    /// Sends the content of the recorder.
    pub fn publish_recorded_span(&self, recorded_span: &RecordedSpan) {
        let mut last = self.lock();
        let mut message = json!(recorded_span);
        message["t"] = json!("timeline");
        last.recorded_span = Some(self.publish(&message));
    }

    /// Sets the policy that is running: a task can be restarted with another one.
    pub fn set_policy(&self, policy: &str) {
        let mut last = self.lock();
        // Compared first: at 4 Hz an unchanged name need not be copied again.
        if last.hello.run.policy != policy {
            policy.clone_into(&mut last.hello.run.policy);
        }
    }

    /// The policy that is running.
    pub fn policy(&self) -> String {
        self.lock().hello.run.policy.clone()
    }

    /// Sets the speed of simulated time, which can change while the cell runs.
    pub fn set_speed(&self, speed: &str) {
        let mut last = self.lock();
        if last.hello.run.speed != speed {
            speed.clone_into(&mut last.hello.run.speed);
        }
    }

    /// The scene.
    pub fn scene(&self) -> Arc<Value> {
        self.lock().scene.clone()
    }

    /// Ends every connection; the first reason is the one sent.
    pub fn close(&self, reason: &'static str) {
        self.close_reason.send_if_modified(|close_reason| {
            let first = close_reason.is_none();
            close_reason.get_or_insert(reason);
            first
        });
    }

    /// Ready once the broadcast is closed.
    pub async fn closed(&self) {
        let mut close_reason = self.close_reason.subscribe();
        let _closed = close_reason.wait_for(Option::is_some).await.is_ok();
    }

    /// Receivers of a new client; nothing is sent twice, and nothing is left out.
    pub fn subscribe(&self, role: Role) -> Subscription {
        let mut frames = self.frames.subscribe();
        // The present frame is new to this client.
        frames.mark_changed();
        // Subscribed under the lock: a message between state and subscription would be lost.
        let last = self.lock();
        Subscription {
            frames,
            messages: self.messages.subscribe(),
            close_reason: self.close_reason.subscribe(),
            state: last.full_state(role),
        }
    }

    /// The whole trace of the task.
    pub fn trace(&self) -> Vec<Utf8Bytes> {
        self.lock().trace.full_state().iter().map(text).collect()
    }

    fn publish(&self, message: &Value) -> Utf8Bytes {
        let text = text(message);
        if self.messages.receiver_count() > 0 {
            // The last client may leave at this moment.
            let _heard = self.messages.send(text.clone()).is_ok();
        }
        text
    }

    fn lock(&self) -> MutexGuard<'_, LastState> {
        self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LastState {
    fn full_state(&self, role: Role) -> Vec<Utf8Bytes> {
        let mut hello = json!(self.hello);
        hello["t"] = json!("hello");
        hello["role"] = json!(role.name());
        let mut all = vec![
            text(&hello),
            text(&json!({ "t": "scene", "scene": *self.scene })),
        ];
        all.extend(self.trace.full_state().iter().map(text));
        all.push(text(&self.timeline.message(None)));
        all.extend(self.marks.clone());
        all.extend(self.status.clone());
        all.extend(self.recorded_span.clone());
        all
    }
}

fn text(message: &Value) -> Utf8Bytes {
    Utf8Bytes::from(message.to_string())
}
