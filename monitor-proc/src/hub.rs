//! Distributes frames and news to pages: the newest frame, and news with the last known state
//! for late joiners. Fed by the bus, by a replayed file, or by a test.
//!
//! Feeding never waits for a page: frames are replaced, and news beyond the buffer are replaced
//! by the whole state. `join` and every `tell` hold one lock, so that a page gets each message
//! exactly once, in its state or as news.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use cell_model::runs::incident::Head;
use cell_record::EpochSpan;
use ipc_types::TraceLine;
use ipc_types::trace::TraceEvent;
use serde::Serialize;
use serde_json::{Value, json};
use tokio::sync::{broadcast, watch};

use crate::lanes::{Lanes, Span};
use crate::page::role::Role;
use crate::story::Story;
use crate::story::history::History;

/// News that a slow reader can be behind; then everything is sent again.
// Bounds memory: a page that is further behind gets the whole state instead.
const WAITING_NEWS: usize = 512;

/// The run as the page names it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RunInfo {
    /// 16 hexadecimal digits.
    pub id: String,
    /// Name of the cell.
    pub cell: String,
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// Seed of the run.
    pub seed: u64,
    /// `1`, `max`, or a factor.
    pub speed: String,
}

/// A demo that can be loaded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DemoInfo {
    /// Its name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Policies that can run it.
    pub policies: Vec<String>,
    /// The policy used if none is given.
    pub default_policy: String,
}

/// First message to a client, without its role.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hello {
    /// False for a replayed file.
    pub live: bool,
    /// The run.
    pub run: RunInfo,
    /// Demos that can be loaded.
    pub demos: Vec<DemoInfo>,
    /// Name of the replayed file.
    pub source: Option<String>,
}

/// Simulated time that the recorder holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Timeline {
    /// First time of the newest epoch's history (s).
    pub from_s: f64,
    /// Last time of it (s).
    pub to_s: f64,
    /// Every epoch, oldest first: generations of physics.
    pub epochs: Vec<EpochSpan>,
}

/// Last state of everything that is sent to pages.
struct Known {
    hello: Hello,
    scene: Arc<Value>,
    story: Story,
    history: History,
    lanes: Lanes,
    status: Option<Utf8Bytes>,
    timeline: Option<Utf8Bytes>,
}

/// Receivers of one client.
pub struct Joined {
    /// The newest frame; empty before the first.
    pub frames: watch::Receiver<Bytes>,
    /// News from now on.
    pub news: broadcast::Receiver<Utf8Bytes>,
    /// Reason why the connection has to end, once it has to.
    pub gone: watch::Receiver<Option<&'static str>>,
    /// Everything sent before.
    pub state: Vec<Utf8Bytes>,
}

/// Feeds the pages. Feeding never blocks.
pub struct Hub {
    frames: watch::Sender<Bytes>,
    news: broadcast::Sender<Utf8Bytes>,
    gone: watch::Sender<Option<&'static str>>,
    known: Mutex<Known>,
}

impl Hub {
    /// A hub that knows only the scene.
    pub fn new(hello: Hello, scene: Value) -> Arc<Self> {
        let known = Known {
            hello,
            scene: Arc::new(scene),
            story: Story::default(),
            history: History::default(),
            lanes: Lanes::default(),
            status: None,
            timeline: None,
        };
        Arc::new(Self {
            frames: watch::Sender::new(Bytes::new()),
            news: broadcast::Sender::new(WAITING_NEWS),
            gone: watch::Sender::new(None),
            known: Mutex::new(known),
        })
    }

    /// Whether a page is connected.
    pub fn is_watched(&self) -> bool {
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

    /// Sets the epoch, a generation of physics, of all that follows.
    pub fn set_epoch(&self, epoch: u32) {
        self.lock().story.set_epoch(epoch);
    }

    /// Takes a line of the task's trace; [`Self::tell_news`] sends it.
    pub fn take_line(&self, line: &TraceLine) {
        let mut known = self.lock();
        let known = &mut *known;
        let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
        // The history before the line: it keeps the state before this time.
        known.history.next(time_s, &known.story);
        known.story.take(line);
    }

    /// Statuses of the task's pictures some seconds before `time_s`, with that time; none if no
    /// page was served then.
    pub fn story_before(&self, time_s: f64) -> Option<(f64, Story)> {
        self.lock().history.before(time_s)
    }

    /// Adds a line without an event to the log.
    pub fn say(&self, time_s: f64, kind: &str, text: &str) {
        let mut known = self.lock();
        known.story.say(time_s, kind, TraceEvent::None, text);
    }

    /// Adds a line about a process that was restarted to the log.
    pub fn restarted(&self, time_s: f64, text: &str) {
        let mut known = self.lock();
        known
            .story
            .say(time_s, "lifecycle", TraceEvent::Restart, text);
    }

    /// Adds a warning about the inputs of the run to the log.
    pub fn warn(&self, text: &str) {
        let text = format!("[warning] {text}");
        let mut known = self.lock();
        known.story.say(0.0, "lifecycle", TraceEvent::None, &text);
    }

    /// Adds an incident to the log, and the reason to the lane of the process.
    pub fn incident(&self, head: &Head, what: &str) {
        let mut known = self.lock();
        known.story.incident(head, what);
        known.lanes.explain(what);
    }

    /// Changes the lanes of the timeline; [`Self::tell_lanes`] sends the changes.
    pub fn change_lanes(&self, change: impl FnOnce(&mut Lanes)) {
        change(&mut self.lock().lanes);
    }

    /// Sends the changes of the timeline's lanes and returns them.
    pub fn tell_lanes(&self) -> Vec<Span> {
        let mut known = self.lock();
        let news = known.lanes.news();
        if !news.is_empty() {
            self.tell(&known.lanes.message(Some(&news)));
        }
        news
    }

    /// Shows other lanes.
    pub fn replace_lanes(&self, lanes: Lanes) {
        let mut known = self.lock();
        known.lanes = lanes;
        // Sent as a whole below, so they are not news.
        known.lanes.news();
        self.tell(&known.lanes.message(None));
    }

    /// Replaces the task's story: another time is shown from now on.
    pub fn forget_story(&self, story: Story) {
        let mut known = self.lock();
        known.story = story;
        self.tell(&json!({ "t": "now" }));
        for message in known.story.everything() {
            self.tell(&message);
        }
        // Its news are part of what was just sent.
        known.story.news();
    }

    /// Adds lines that an earlier start of the monitor sent.
    pub fn recall(&self, lines: Vec<Value>) {
        self.lock().story.recall(lines);
    }

    /// Sends the news of the task's story; returns its new lines of the log.
    pub fn tell_news(&self) -> Vec<Value> {
        let mut known = self.lock();
        let mut lines = Vec::new();
        for message in known.story.news() {
            self.tell(&message);
            if let Some(new) = message["lines"].as_array() {
                lines.extend(new.iter().cloned());
            }
        }
        lines
    }

    /// Sends the health of all processes.
    pub fn tell_status(&self, status: &Value) {
        let mut known = self.lock();
        known.status = Some(self.tell(status));
    }

    /// Sends the content of the recorder.
    pub fn tell_timeline(&self, timeline: &Timeline) {
        let mut known = self.lock();
        let mut message = json!(timeline);
        message["t"] = json!("timeline");
        known.timeline = Some(self.tell(&message));
    }

    /// Sets the policy that is running: a task can be restarted with another one.
    pub fn set_policy(&self, policy: &str) {
        let mut known = self.lock();
        // Compared first: at 4 Hz an unchanged name need not be copied again.
        if known.hello.run.policy != policy {
            policy.clone_into(&mut known.hello.run.policy);
        }
    }

    /// The policy that is running.
    pub fn policy(&self) -> String {
        self.lock().hello.run.policy.clone()
    }

    /// Sets the speed of simulated time, which can change while the cell runs.
    pub fn set_speed(&self, speed: &str) {
        let mut known = self.lock();
        if known.hello.run.speed != speed {
            speed.clone_into(&mut known.hello.run.speed);
        }
    }

    /// The scene.
    pub fn scene(&self) -> Arc<Value> {
        self.lock().scene.clone()
    }

    /// Ends every connection; the first reason is the one sent.
    pub fn close(&self, why: &'static str) {
        self.gone.send_if_modified(|gone| {
            let first = gone.is_none();
            gone.get_or_insert(why);
            first
        });
    }

    /// Ready once the hub is closed.
    pub async fn closed(&self) {
        let mut gone = self.gone.subscribe();
        let _closed = gone.wait_for(Option::is_some).await.is_ok();
    }

    /// Receivers of a new client; nothing is sent twice, and nothing is left out.
    pub fn join(&self, role: Role) -> Joined {
        let mut frames = self.frames.subscribe();
        // The present frame is news to this client.
        frames.mark_changed();
        // Subscribed under the lock: a message between state and subscription would be lost.
        let known = self.lock();
        Joined {
            frames,
            news: self.news.subscribe(),
            gone: self.gone.subscribe(),
            state: known.everything(role),
        }
    }

    /// The whole story of the task.
    pub fn story(&self) -> Vec<Utf8Bytes> {
        self.lock().story.everything().iter().map(text).collect()
    }

    fn tell(&self, message: &Value) -> Utf8Bytes {
        let text = text(message);
        if self.news.receiver_count() > 0 {
            // The last client may leave at this moment.
            let _heard = self.news.send(text.clone()).is_ok();
        }
        text
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Known {
    fn everything(&self, role: Role) -> Vec<Utf8Bytes> {
        let mut hello = json!(self.hello);
        hello["t"] = json!("hello");
        hello["role"] = json!(role.name());
        let mut all = vec![
            text(&hello),
            text(&json!({ "t": "scene", "scene": *self.scene })),
        ];
        all.extend(self.story.everything().iter().map(text));
        all.push(text(&self.lanes.message(None)));
        all.extend(self.status.clone());
        all.extend(self.timeline.clone());
        all
    }
}

fn text(message: &Value) -> Utf8Bytes {
    Utf8Bytes::from(message.to_string())
}
