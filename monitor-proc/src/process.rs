//! The monitor on the bus: reads the task's trace, writes its log, publishes to the page.
//!
//! The monitor may be killed at any time and must not slow down the cell. So it only reads
//! topics with overflow, sleeps instead of being woken, and continues files of an earlier
//! start. Parts that can fail (page, recorder, scene) fail alone: their problem is in the
//! health note, and the rest continues. A change must not make `update` wait for a page, a disk
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

use crate::feed::broadcast::Broadcast;
use crate::feed::publisher::{Publisher, RecorderUpdate};
use crate::operator::queue::{LiveCommandQueue, serve_control, serve_physics};
use crate::operator::recordings;
use crate::recorder::Recorder;
use crate::timeline::event_file::{self, EventFile};
use crate::timeline::incidents::IncidentWatch;
use crate::timeline::lanes::LaneSpan;
use crate::trace::text_log::{RepeatFilter, TextLog};
use crate::web::page_server::{self, PageError, PageProblem};

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
    let log = TextLog::open(&logs)?;
    let (events, lines) = EventFile::open(&logs, event_file::EVENTS);
    let (timeline, spans) = EventFile::open(&logs, event_file::LANES);
    let earlier = EarlierLog { lines, spans };
    let problem = PageProblem::default();
    // Without a scene the page is empty, but log and recording work.
    let scene = page_server::scene(start).unwrap_or_else(|error| {
        problem.set(error.to_string());
        Value::Null
    });
    // Before the page: its first request may already be for a recording.
    let recorder = Arc::new(Recorder::start(start, scene.clone()));
    // Scoped threads: none of them outlives the run, so the files are closed at the end.
    thread::scope(|scope| {
        let page = start.spec.page.as_ref();
        let page = page.and_then(|page| {
            // A cell whose page cannot be shown is still a cell.
            let opened = Page::open(scope, start, page, scene, (&recorder, &problem), &earlier);
            opened.map_err(|error| problem.set(error.to_string())).ok()
        });
        let bus = start.join(Process::Monitor)?;
        let mut process = MonitorProcess::new(&bus, start, log, page)?;
        process.resume(events, timeline, &earlier.lines, &start.spec);
        process.problem = problem;
        process.recorder = Some(recorder.clone());
        while !stop_requested() {
            process.update();
        }
        // The last lines still have to be written.
        process.drain();
        Ok(())
    })
}

/// Log and timeline of an earlier start of the monitor.
struct EarlierLog {
    /// The log.
    lines: Vec<Value>,
    /// The lanes of the timeline.
    spans: Vec<Value>,
}

impl EarlierLog {
    fn restore_into(&self, broadcast: &Broadcast) {
        broadcast.restore_log(self.lines.clone());
        let spans = self.spans.iter().cloned().map(serde_json::from_value);
        let spans: Vec<LaneSpan> = spans.filter_map(Result::ok).collect();
        broadcast.change_timeline(|timeline| timeline.restore(spans));
    }
}

/// The page's channels on the thread of the bus.
struct Page {
    broadcast: Arc<Broadcast>,
    requests: mpsc::Receiver<String>,
}

impl Page {
    /// Starts the threads of the page: they end when it is closed.
    fn open<'scope>(
        scope: &'scope Scope<'scope, '_>,
        start: &'scope Start,
        page: &'scope PageSpec,
        scene: Value,
        (recorder, problem): (&Arc<Recorder>, &PageProblem),
        earlier: &EarlierLog,
    ) -> Result<Self, PageError> {
        let (queue, receivers) = LiveCommandQueue::new();
        let server = page_server::prepare(start, page, scene, queue, recorder)?;
        // Before the first page connects: each line of the log is sent to it once.
        earlier.restore_into(&server.broadcast);
        // Warnings of the run are in the log already if this is a later start.
        if earlier.lines.is_empty() {
            start
                .spec
                .warnings
                .iter()
                .for_each(|text| server.broadcast.warn(text));
        }
        let (physics, control) = (receivers.physics, receivers.control);
        let (recorder, problem) = (recorder.clone(), problem.clone());
        let opened = Page {
            broadcast: server.broadcast.clone(),
            requests: receivers.log,
        };
        let named = |name: &str| thread::Builder::new().name(name.to_owned());
        // One thread per recipient: a restart takes seconds, and a drag must not wait for it.
        named("operator").spawn_scoped(scope, move || serve_physics(start, &physics))?;
        let socket = start.spec.run_dir.join("control.sock");
        named("errands").spawn_scoped(scope, move || {
            let record = |order| recordings::record(&recorder, &start.spec, order);
            serve_control(&socket, &control, record);
        })?;
        named("page").spawn_scoped(scope, move || {
            page_server::serve(server, page.address, &problem);
        })?;
        Ok(opened)
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // For any reason: the threads must end. A reason set before stays.
        self.broadcast.close("restart");
    }
}

/// State of the recorder for a status message; its span once a second.
fn update_of(recorder: &Recorder, now_ns: u64, due_ns: &mut u64) -> RecorderUpdate {
    let status = recorder.status();
    let due = now_ns >= *due_ns;
    if due {
        *due_ns = now_ns + TIMELINE_NS;
    }
    RecorderUpdate {
        status_parts: Some((json!(status), json!(recorder.latency()))),
        to_file: status.file.is_some(),
        recorded_span: due.then_some(status.recorded_span),
    }
}

struct MonitorProcess {
    log: TextLog<File>,
    trace: Subscriber<TraceLine>,
    state: Subscriber<WorldState>,
    gaps: u64,
    tick: u64,
    ending: bool,
    publisher: Option<Publisher>,
    page: Option<Page>,
    problem: PageProblem,
    recorder: Option<Arc<Recorder>>,
    next_timeline_ns: u64,
    incidents: IncidentWatch,
    events: Option<EventFile>,
    timeline: Option<EventFile>,
    repeats: RepeatFilter,
    health: HealthReporter,
}

impl MonitorProcess {
    fn new(
        bus: &Bus,
        start: &Start,
        log: TextLog<File>,
        page: Option<Page>,
    ) -> Result<Self, BusError> {
        let publisher = page
            .as_ref()
            .map(|page| Publisher::new(bus, start, page.broadcast.clone()));
        Ok(Self {
            log,
            trace: bus.subscriber(TopicId::Trace)?,
            state: bus.subscriber(TopicId::WorldState)?,
            gaps: 0,
            tick: 0,
            ending: false,
            publisher: publisher.transpose()?,
            page,
            problem: PageProblem::default(),
            recorder: None,
            next_timeline_ns: 0,
            incidents: IncidentWatch::new(&start.spec, 0, 0),
            events: None,
            timeline: None,
            repeats: RepeatFilter::default(),
            health: HealthReporter::new(start, bus, Process::Monitor, false, monotonic_ns())?,
        })
    }

    /// Continues the files of an earlier start; `lines` are those of its log.
    fn resume(&mut self, events: EventFile, timeline: EventFile, lines: &[Value], spec: &RunSpec) {
        // Incidents of the log so far are not reported again.
        let numbers = || lines.iter().filter_map(|line| line["incident"].as_u64());
        let newest = numbers().max().unwrap_or(0);
        let of_newest = numbers().filter(|number| *number == newest).count();
        let number = u32::try_from(newest).unwrap_or(0);
        self.incidents = IncidentWatch::new(spec, number, of_newest);
        self.events = Some(events);
        self.timeline = Some(timeline);
    }

    fn update(&mut self) {
        let start_ns = monotonic_ns();
        // First, so that lines drained below are assigned to the right epoch.
        if let Some(state) = self.state.take() {
            self.tick = state.header.tick;
            self.ending = state.has(FLAG_ENDING);
            if let Some(page) = &self.page {
                page.broadcast.set_epoch(state.header.generation);
            }
        }
        // The trace before the page's frames: a frame must not show what its log does not know.
        self.drain();
        // Requests after the trace: a person's action follows the line that caused it.
        self.log_requests(start_ns);
        if let Some(page) = &self.page {
            for (head, what) in self.incidents.take_new(start_ns) {
                page.broadcast.add_incident(&head, &what);
            }
        }
        if let Some(publisher) = &mut self.publisher {
            let recorder = self.recorder.as_deref();
            let due = &mut self.next_timeline_ns;
            let lines = publisher.update(start_ns, || {
                recorder.map_or_else(RecorderUpdate::default, |r| update_of(r, start_ns, due))
            });
            if let Some(events) = &mut self.events {
                events.append(&lines);
            }
            let spans = publisher.broadcast().publish_timeline();
            let spans: Vec<Value> = spans.iter().map(|s| json!(s)).collect();
            if let Some(timeline) = &mut self.timeline {
                timeline.append(&spans);
            }
        }
        // A sleeping process has no deadline, so its lateness is 0.
        let now_ns = monotonic_ns();
        self.health.cycle(self.tick, start_ns, 0, [0.0; 4], now_ns);
        let counts = self.trace.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        self.note_problem();
        self.health.publish_if_due(self.tick, now_ns);
        let publisher = self.publisher.as_ref();
        let idle_ns = publisher.map_or(u64::MAX, |publisher| publisher.idle_ns(now_ns));
        // The page's rate or the longest pause: a cell without a page wakes 20 times a second.
        sleep_until(now_ns + idle_ns.min(LONGEST_NS));
    }

    fn note_problem(&mut self) {
        // Lost lines first: they are not repeated, while the problem of a page stays.
        if self.log.lost() > 0 {
            self.health.note(&format!(
                "the disk did not take {} lines of the log",
                self.log.lost()
            ));
        } else if let Some(note) = self.problem.note() {
            self.health.note(&note);
        }
    }

    /// Writes requests of people to the log and the page.
    fn log_requests(&mut self, now_ns: u64) {
        let Some(page) = &self.page else {
            return;
        };
        let time_s = (self.tick * TICK_NS) as f64 / 1.0e9;
        for text in page.requests.try_iter() {
            if self.repeats.is_new(&text, now_ns) {
                let text = format!("operator: {text}");
                self.log.operator(time_s, &text);
                page.broadcast.add_log_line(time_s, "lifecycle", &text);
            }
        }
    }

    fn drain(&mut self) {
        let log = &mut self.log;
        let broadcast = self.publisher.as_ref().map(Publisher::broadcast);
        self.trace.take_all(|line| {
            log.line(line);
            if let Some(broadcast) = broadcast {
                broadcast.take_line(line);
            }
        });
        // Reported as a line of the log: a gap must be visible where it is.
        let gaps = self.trace.counts().late;
        if gaps > self.gaps {
            let missing = gaps - self.gaps;
            self.log.gap(missing);
            if let Some(broadcast) = broadcast {
                let text = format!("[monitor] {missing} lines of the task were not read in time");
                let time_s = self.tick as f64 * TICK_NS as f64 / 1.0e9;
                broadcast.add_log_line(time_s, "lifecycle", &text);
            }
            self.gaps = gaps;
        }
    }
}

impl Drop for MonitorProcess {
    fn drop(&mut self) {
        // An ending cell and a restarting monitor are different messages on the page.
        if let Some(page) = &self.page {
            page.broadcast
                .close(if self.ending { "end" } else { "restart" });
        }
    }
}
