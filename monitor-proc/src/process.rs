//! The monitor on the bus: reads the task's trace, writes its log, feeds the page.
//!
//! The monitor may be killed at any time and must not slow down the cell. So it only reads
//! topics with overflow, sleeps instead of being woken, and continues files of an earlier
//! start. Parts that can fail (page, recorder, scene) fail alone: their trouble is in the
//! health note, and the rest continues. A change must not make `turn` wait for a page, a disk
//! or another process.

use std::fs::File;
use std::sync::{Arc, mpsc};
use std::thread::{self, Scope};

use cell_bus::{Bus, BusError, Subscriber};
use cell_model::runs::spec::{PageSpec, RunSpec};
use cell_rt::{monotonic_ns, signal::stop_requested, sleep_until};
use cell_worker::{HealthReporter, RunError, Start};
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_ENDING;
use ipc_types::{TICK_NS, TraceLine, WorldState};
use serde_json::{Value, json};

use crate::desk::{LiveDesk, serve_errands, serve_physics};
use crate::events::{self, EventFile};
use crate::feed::{Feed, RecorderNews};
use crate::incidents::IncidentWatch;
use crate::journal::{Journal, Said};
use crate::keep;
use crate::lanes::Span;
use crate::live::{self, PageError, Trouble};
use crate::recorder::Recorder;

/// Longest time between two reads of the taps (ns): their buffers hold thousands of lines, and
/// no person reads a log faster. Nothing wakes the monitor before: a ring at every decision was
/// most of its cost.
const LONGEST_NS: u64 = 50_000_000;
/// Interval at which the span of the flight recorder is sent (ns).
const TIMELINE_NS: u64 = 1_000_000_000;

/// Reasons why a monitor cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The log folder.
    #[error("logs of the run: {0}; check that the run directory belongs to you")]
    Journal(#[from] std::io::Error),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl RunError for ProcessError {
    fn is_lasting(&self) -> bool {
        match self {
            // A full disk or a missing folder may be repaired, so the launcher tries again.
            Self::Journal(_) => false,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

/// Runs the monitor until a stop is requested.
///
/// # Errors
///
/// When the log cannot be opened, or the bus cannot be joined.
pub fn run(start: &Start) -> Result<(), ProcessError> {
    let logs = start.spec.run_dir.join("logs");
    std::fs::create_dir_all(&logs)?;
    // Before the bus is joined: all that can fail is done
    // while no file of the transport exists.
    let journal = Journal::open(&logs)?;
    let (events, lines) = EventFile::open(&logs, events::EVENTS);
    let (lanes, spans) = EventFile::open(&logs, events::LANES);
    let told = Told { lines, spans };
    let trouble = Trouble::default();
    // Without a scene the page is empty, but log and recording work.
    let scene = live::scene(start).unwrap_or_else(|error| {
        trouble.set(error.to_string());
        Value::Null
    });
    // Before the page: its first request may already be for a recording.
    let recorder = Arc::new(Recorder::start(start, scene.clone()));
    // Scoped threads: none of them outlives the run, so the files are closed at the end.
    thread::scope(|scope| {
        let page = start.spec.page.as_ref();
        let page = page.and_then(|page| {
            // A cell whose page cannot be shown is still a cell.
            let opened = Page::open(scope, start, page, scene, (&recorder, &trouble), &told);
            opened.map_err(|error| trouble.set(error.to_string())).ok()
        });
        let bus = start.join(Process::Monitor)?;
        let mut process = MonitorProcess::new(&bus, start, journal, page)?;
        process.resume(events, lanes, &told.lines, &start.spec);
        process.trouble = trouble;
        process.recorder = Some(recorder.clone());
        while !stop_requested() {
            process.turn();
        }
        // The last lines still have to be written.
        process.drain();
        Ok(())
    })
}

/// Log and timeline sent by an earlier start of the monitor.
struct Told {
    /// The log.
    lines: Vec<Value>,
    /// The lanes of the timeline.
    spans: Vec<Value>,
}

impl Told {
    fn recall(&self, hub: &crate::hub::Hub) {
        hub.recall(self.lines.clone());
        let spans = self.spans.iter().cloned().map(serde_json::from_value);
        let spans: Vec<Span> = spans.filter_map(Result::ok).collect();
        hub.change_lanes(|lanes| lanes.recall(spans));
    }
}

/// The page's ends on the thread of the bus.
struct Page {
    hub: Arc<crate::hub::Hub>,
    said: mpsc::Receiver<String>,
}

impl Page {
    /// Starts the threads of the page: they end when it is closed.
    fn open<'scope>(
        scope: &'scope Scope<'scope, '_>,
        start: &'scope Start,
        page: &'scope PageSpec,
        scene: Value,
        (recorder, trouble): (&Arc<Recorder>, &Trouble),
        told: &Told,
    ) -> Result<Self, PageError> {
        let (desk, counters) = LiveDesk::new();
        let site = live::prepare(start, page, scene, desk, recorder)?;
        // Before the first page connects: each line of the log is sent to it once.
        told.recall(&site.hub);
        // Warnings of the run are in the log already if this is a later start.
        if told.lines.is_empty() {
            start
                .spec
                .warnings
                .iter()
                .for_each(|text| site.hub.warn(text));
        }
        let (physics, errands) = (counters.physics, counters.errands);
        let (recorder, trouble) = (recorder.clone(), trouble.clone());
        let opened = Page {
            hub: site.hub.clone(),
            said: counters.journal,
        };
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        // One thread per recipient: a restart takes seconds, and a drag must not wait for it.
        named("operator").spawn_scoped(scope, move || serve_physics(start, &physics))?;
        let control = start.spec.run_dir.join("control.sock");
        named("errands").spawn_scoped(scope, move || {
            let record = |order| keep::record(&recorder, &start.spec, order);
            serve_errands(&control, &errands, record);
        })?;
        named("page").spawn_scoped(scope, move || live::serve(site, page.address, &trouble))?;
        Ok(opened)
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // For any reason: the threads must end. A reason set before stays.
        self.hub.close("restart");
    }
}

/// News of the recorder for a status; its span once a second.
fn news(recorder: &Recorder, now_ns: u64, due_ns: &mut u64) -> RecorderNews {
    let status = recorder.status();
    let due = now_ns >= *due_ns;
    if due {
        *due_ns = now_ns + TIMELINE_NS;
    }
    RecorderNews {
        told: Some((json!(status), json!(recorder.latency()))),
        to_file: status.file.is_some(),
        timeline: due.then_some(status.timeline),
    }
}

struct MonitorProcess {
    journal: Journal<File>,
    trace: Subscriber<TraceLine>,
    state: Subscriber<WorldState>,
    gaps: u64,
    tick: u64,
    ending: bool,
    feed: Option<Feed>,
    page: Option<Page>,
    trouble: Trouble,
    recorder: Option<Arc<Recorder>>,
    next_timeline_ns: u64,
    incidents: IncidentWatch,
    events: Option<EventFile>,
    lanes: Option<EventFile>,
    said: Said,
    health: HealthReporter,
}

impl MonitorProcess {
    fn new(
        bus: &Bus,
        start: &Start,
        journal: Journal<File>,
        page: Option<Page>,
    ) -> Result<Self, BusError> {
        let feed = page
            .as_ref()
            .map(|page| Feed::new(bus, start, page.hub.clone()));
        Ok(Self {
            journal,
            trace: bus.subscriber(TopicId::Trace)?,
            state: bus.subscriber(TopicId::WorldState)?,
            gaps: 0,
            tick: 0,
            ending: false,
            feed: feed.transpose()?,
            page,
            trouble: Trouble::default(),
            recorder: None,
            next_timeline_ns: 0,
            incidents: IncidentWatch::new(&start.spec, 0, 0),
            events: None,
            lanes: None,
            said: Said::default(),
            health: HealthReporter::new(start, bus, Process::Monitor, false, monotonic_ns())?,
        })
    }

    /// Continues the files of an earlier start; `lines` are those of its log.
    fn resume(&mut self, events: EventFile, lanes: EventFile, lines: &[Value], spec: &RunSpec) {
        // Incidents of the log so far are not reported again.
        let told = || lines.iter().filter_map(|line| line["incident"].as_u64());
        let newest = told().max().unwrap_or(0);
        let of_newest = told().filter(|number| *number == newest).count();
        let number = u32::try_from(newest).unwrap_or(0);
        self.incidents = IncidentWatch::new(spec, number, of_newest);
        self.events = Some(events);
        self.lanes = Some(lanes);
    }

    fn turn(&mut self) {
        let began_ns = monotonic_ns();
        // First, so that lines drained below are assigned to the right epoch.
        if let Some(state) = self.state.take() {
            self.tick = state.header.tick;
            self.ending = state.has(FLAG_ENDING);
            if let Some(page) = &self.page {
                page.hub.set_epoch(state.header.generation);
            }
        }
        // The trace before the page's frames: a frame must not show what its log does not know.
        self.drain();
        // Requests after the trace: a person's action follows the line that caused it.
        self.write_down(began_ns);
        if let Some(page) = &self.page {
            for (head, what) in self.incidents.news(began_ns) {
                page.hub.incident(&head, &what);
            }
        }
        if let Some(feed) = &mut self.feed {
            let recorder = self.recorder.as_deref();
            let due = &mut self.next_timeline_ns;
            let lines = feed.turn(began_ns, || {
                recorder.map_or_else(RecorderNews::default, |r| news(r, began_ns, due))
            });
            if let Some(events) = &mut self.events {
                events.append(&lines);
            }
            let spans: Vec<Value> = feed.hub().tell_lanes().iter().map(|s| json!(s)).collect();
            if let Some(lanes) = &mut self.lanes {
                lanes.append(&spans);
            }
        }
        // A sleeping process has no deadline, so its lateness is 0.
        let now_ns = monotonic_ns();
        self.health.cycle(self.tick, began_ns, 0, [0.0; 4], now_ns);
        let counts = self.trace.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        self.say_trouble();
        self.health.publish_if_due(self.tick, now_ns);
        let feed = self.feed.as_ref();
        let idle_ns = feed.map_or(u64::MAX, |feed| feed.idle_ns(now_ns));
        // The page's rate or the longest pause: a cell without a page wakes 20 times a second.
        sleep_until(now_ns + idle_ns.min(LONGEST_NS));
    }

    fn say_trouble(&mut self) {
        // Lost lines first: they are not repeated, while the trouble of a page stays.
        if self.journal.lost() > 0 {
            self.health.note(&format!(
                "the disk did not take {} lines of the log",
                self.journal.lost()
            ));
        } else if let Some(note) = self.trouble.note() {
            self.health.note(&note);
        }
    }

    /// Writes requests of people to the log and the page.
    fn write_down(&mut self, now_ns: u64) {
        let Some(page) = &self.page else {
            return;
        };
        let time_s = (self.tick * TICK_NS) as f64 / 1.0e9;
        for text in page.said.try_iter() {
            if self.said.is_new(&text, now_ns) {
                let text = format!("operator: {text}");
                self.journal.operator(time_s, &text);
                page.hub.say(time_s, "lifecycle", &text);
            }
        }
    }

    fn drain(&mut self) {
        let journal = &mut self.journal;
        let hub = self.feed.as_ref().map(Feed::hub);
        self.trace.take_all(|line| {
            journal.line(line);
            if let Some(hub) = hub {
                hub.take_line(line);
            }
        });
        // Reported as a line of the log: a gap must be visible where it is.
        let gaps = self.trace.counts().late;
        if gaps > self.gaps {
            let missing = gaps - self.gaps;
            self.journal.gap(missing);
            if let Some(hub) = hub {
                let text = format!("[monitor] {missing} lines of the task were not read in time");
                hub.say(
                    self.tick as f64 * TICK_NS as f64 / 1.0e9,
                    "lifecycle",
                    &text,
                );
            }
            self.gaps = gaps;
        }
    }
}

impl Drop for MonitorProcess {
    fn drop(&mut self) {
        // An ending cell and a restarting monitor are different messages on the page.
        if let Some(page) = &self.page {
            page.hub.close(if self.ending { "end" } else { "restart" });
        }
    }
}
