//! What pages are fed from: the newest frame, and slow news with the last known
//! state for late joiners. Filled by the bus, by a replayed file, or by a test.

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

/// News a slow reader can be behind; then everything is sent again.
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
    /// The one that runs where none is named.
    pub default_policy: String,
}

/// What a client is told first, but for its role.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Hello {
    /// False for a replayed file.
    pub live: bool,
    /// The run.
    pub run: RunInfo,
    /// What can be loaded.
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

/// Last state of all that is told.
struct Known {
    hello: Hello,
    scene: Arc<Value>,
    story: Story,
    history: History,
    lanes: Lanes,
    status: Option<Utf8Bytes>,
    timeline: Option<Utf8Bytes>,
}

/// A client's ends.
pub struct Joined {
    /// The newest frame; empty before the first.
    pub frames: watch::Receiver<Bytes>,
    /// News from now on.
    pub news: broadcast::Receiver<Utf8Bytes>,
    /// Why the connection has to end, once it has to.
    pub gone: watch::Receiver<Option<&'static str>>,
    /// All that was told before.
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
    /// A hub that knows no more than the scene.
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

    /// Whether anybody looks.
    pub fn is_watched(&self) -> bool {
        self.frames.receiver_count() > 0
    }

    /// Shows a frame; the one before is forgotten, seen or not. A frame that is
    /// the same as the one before is none.
    pub fn frame(&self, frame: Vec<u8>) {
        self.frames.send_if_modified(|newest| {
            let new = *newest != frame;
            if new {
                *newest = Bytes::from(frame);
            }
            new
        });
    }

    /// Says that what follows is of `epoch`, a generation of physics.
    pub fn set_epoch(&self, epoch: u32) {
        self.lock().story.set_epoch(epoch);
    }

    /// Takes a line of the task's trace; [`Self::tell_news`] tells it.
    pub fn take_line(&self, line: &TraceLine) {
        let mut known = self.lock();
        let known = &mut *known;
        let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
        known.history.next(time_s, &known.story);
        known.story.take(line);
    }

    /// How the task's pictures stood some seconds before `time_s`, and when that was;
    /// none where no page listened then.
    pub fn story_before(&self, time_s: f64) -> Option<(f64, Story)> {
        self.lock().history.before(time_s)
    }

    /// Adds a line to the log that no event belongs to.
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

    /// Changes the lanes of the timeline; [`Self::tell_lanes`] tells it.
    pub fn change_lanes(&self, change: impl FnOnce(&mut Lanes)) {
        change(&mut self.lock().lanes);
    }

    /// Tells what is new in the lanes of the timeline; what that is.
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
        known.lanes.news();
        self.tell(&known.lanes.message(None));
    }

    /// Forgets what the task said: another past is shown from now on.
    pub fn forget_story(&self, story: Story) {
        let mut known = self.lock();
        known.story = story;
        self.tell(&json!({ "t": "now" }));
        for message in known.story.everything() {
            self.tell(&message);
        }
        // What it counts as new has just been told.
        known.story.news();
    }

    /// Lines that an earlier start of the monitor told.
    pub fn recall(&self, lines: Vec<Value>) {
        self.lock().story.recall(lines);
    }

    /// Tells what is new in the task's story; the lines of the log that are.
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

    /// Tells what the recorder holds.
    pub fn tell_timeline(&self, timeline: &Timeline) {
        let mut known = self.lock();
        let mut message = json!(timeline);
        message["t"] = json!("timeline");
        known.timeline = Some(self.tell(&message));
    }

    /// The policy that runs now: a task can be restarted with another one.
    pub fn set_policy(&self, policy: &str) {
        let mut known = self.lock();
        if known.hello.run.policy != policy {
            policy.clone_into(&mut known.hello.run.policy);
        }
    }

    /// The policy that runs now.
    pub fn policy(&self) -> String {
        self.lock().hello.run.policy.clone()
    }

    /// How simulated time passes now: that can be changed while the cell runs.
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

    /// Ends every connection; the first reason is the one that is told.
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

    /// A new client's ends; nothing is told twice, and nothing is left out.
    pub fn join(&self, role: Role) -> Joined {
        let mut frames = self.frames.subscribe();
        frames.mark_changed();
        let known = self.lock();
        Joined {
            frames,
            news: self.news.subscribe(),
            gone: self.gone.subscribe(),
            state: known.everything(role),
        }
    }

    /// All of the task's story once more.
    pub fn story(&self) -> Vec<Utf8Bytes> {
        self.lock().story.everything().iter().map(text).collect()
    }

    fn tell(&self, message: &Value) -> Utf8Bytes {
        let text = text(message);
        if self.news.receiver_count() > 0 {
            // The last one may leave at this moment.
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
