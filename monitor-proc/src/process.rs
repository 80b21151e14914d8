//! The monitor on the bus: reads the task's trace, writes its log, publishes to the page.
//!
//! The monitor may be killed at any time and must not slow down the cell. So it only reads
//! topics with overflow, sleeps instead of being woken, and continues files of an earlier
//! start. Parts that can fail (page, recorder, scene) fail alone: their problem is in the
//! health note, and the rest continues. A change must not make `update` wait for a page, a disk
//! or another process.

use std::fs::File;
use std::sync::Arc;
use std::thread;

use cell_bus::{Bus, BusError, Subscriber};
use cell_rt::{monotonic_ns, signal::stop_requested, sleep_until};
use cell_worker::{HealthReporter, RunError, Start};
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_ENDING;
use ipc_types::{TICK_NS, TraceLine, WorldState};
use serde_json::{Value, json};

use crate::feed::broadcast::Broadcast;
use crate::feed::pauses::PauseWatch;
use crate::feed::publisher::{Publisher, RecorderUpdate};
use crate::operator::live_page::LivePage;
use crate::recorder::Recorder;
use crate::timeline::event_file::PageFiles;
use crate::timeline::incidents::IncidentWatch;
use crate::timeline::lanes::LaneSpan;
use crate::trace::text_log::{RepeatFilter, TextLog};
use crate::web::page_server::{self, PageProblem};

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
    let files = PageFiles::open(&logs);
    let problem = PageProblem::default();
    // Without a scene the page is empty, but log and recording work.
    let scene = page_server::scene(start).unwrap_or_else(|error| {
        problem.set(error.to_string());
        Value::Null
    });
    // Before the page: its first request may already be for a recording.
    let recorder = Arc::new(Recorder::start(start, scene.clone()));
    // Also without a page: its log and its lanes are recorded.
    let broadcast = page_server::broadcast(start, scene);
    // Before the first page connects: each line of the log is sent to it once.
    files.restore_into(&broadcast, &start.spec);
    // Scoped threads: none of them outlives the run, so the files are closed at the end.
    thread::scope(|scope| {
        let page = start.spec.page.as_ref().and_then(|page| {
            // A cell whose page cannot be shown is still a cell.
            let opened = LivePage::open(scope, start, page, &broadcast, (&recorder, &problem));
            opened.map_err(|error| problem.set(error.to_string())).ok()
        });
        let bus = start.join(Process::Monitor)?;
        let parts = Parts {
            log,
            files,
            broadcast: broadcast.clone(),
            page,
            problem: problem.clone(),
            recorder: recorder.clone(),
        };
        let mut process = MonitorProcess::new(&bus, start, parts)?;
        while !stop_requested() {
            process.update();
        }
        process.finish();
        Ok(())
    })
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

/// What a monitor has before it joins the bus.
struct Parts {
    log: TextLog<File>,
    files: PageFiles,
    broadcast: Arc<Broadcast>,
    page: Option<LivePage>,
    problem: PageProblem,
    recorder: Arc<Recorder>,
}

struct MonitorProcess {
    log: TextLog<File>,
    trace: Subscriber<TraceLine>,
    state: Subscriber<WorldState>,
    gaps: u64,
    tick: u64,
    ending: bool,
    broadcast: Arc<Broadcast>,
    publisher: Publisher,
    page: Option<LivePage>,
    problem: PageProblem,
    recorder: Arc<Recorder>,
    next_timeline_ns: u64,
    incidents: IncidentWatch,
    /// Spans of the timeline that are to be recorded.
    spans: Vec<LaneSpan>,
    files: PageFiles,
    repeats: RepeatFilter,
    pauses: PauseWatch,
    health: HealthReporter,
}

impl MonitorProcess {
    fn new(bus: &Bus, start: &Start, parts: Parts) -> Result<Self, BusError> {
        let broadcast = parts.broadcast;
        Ok(Self {
            log: parts.log,
            trace: bus.subscriber(TopicId::Trace)?,
            state: bus.subscriber(TopicId::WorldState)?,
            gaps: 0,
            tick: 0,
            ending: false,
            publisher: Publisher::new(bus, start, broadcast.clone())?,
            broadcast,
            page: parts.page,
            problem: parts.problem,
            recorder: parts.recorder,
            next_timeline_ns: 0,
            incidents: parts.files.incidents(&start.spec),
            spans: Vec::new(),
            files: parts.files,
            repeats: RepeatFilter::default(),
            pauses: PauseWatch::default(),
            health: HealthReporter::new(start, bus, Process::Monitor, false, monotonic_ns())?,
        })
    }

    fn update(&mut self) {
        let start_ns = monotonic_ns();
        self.publish(start_ns, start_ns);
        // A sleeping process has no deadline, so its lateness is 0.
        let now_ns = monotonic_ns();
        self.health.cycle(self.tick, start_ns, 0, [0.0; 4], now_ns);
        let counts = self.trace.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        self.note_problem();
        self.health.publish_if_due(self.tick, now_ns);
        let idle_ns = self.publisher.idle_ns(now_ns);
        // The page's rate or the longest pause: a cell without a page wakes 20 times a second.
        sleep_until(now_ns + idle_ns.min(LONGEST_NS));
    }

    /// The last state is shown, and the last lines are written.
    fn finish(&mut self) {
        self.publisher.set_due();
        // A page cannot explain a pause any more.
        self.publish(monotonic_ns(), u64::MAX);
        self.report_incidents(true);
        self.record_page();
    }

    /// Reads new messages and publishes them. A pause before `until_ns` that no page requested is
    /// logged.
    fn publish(&mut self, start_ns: u64, until_ns: u64) {
        // First, so that lines drained below are assigned to the right epoch.
        if let Some(state) = self.state.take() {
            self.tick = state.header.tick;
            self.ending = state.has(FLAG_ENDING);
            self.broadcast.set_epoch(state.header.generation);
            self.pauses.state(state, start_ns);
        }
        // The trace before the page's frames: a frame must not show what its log does not know.
        self.drain();
        // Requests after the trace: a person's action follows the line that caused it.
        self.log_requests(start_ns);
        self.log_pause(until_ns);
        if self.incidents.is_due(start_ns) {
            self.report_incidents(false);
        }
        self.record_page();
        let (recorder, due) = (&self.recorder, &mut self.next_timeline_ns);
        let update = || update_of(recorder, start_ns, due);
        let lines = self.publisher.update(start_ns, update);
        let spans = self.broadcast.publish_timeline();
        self.files.append(&lines, &spans);
        let own = spans.into_iter().filter(|span| !span.is_recorded());
        self.spans.extend(own);
    }

    /// Shows new failures, and records the incidents that are complete, or `at_end` all.
    fn report_incidents(&mut self, at_end: bool) {
        for (head, what) in self.incidents.take_new() {
            self.broadcast.add_incident(&head, &what);
        }
        for incident in self.incidents.take_whole(at_end) {
            self.recorder.record_page(json!({ "incident": incident }));
        }
    }

    /// Records what the page shows beside the messages of the bus.
    fn record_page(&mut self) {
        let lines = self.broadcast.take_own_lines();
        let spans = std::mem::take(&mut self.spans);
        if lines.len() + spans.len() > 0 {
            let message = json!({ "lines": lines, "spans": spans });
            self.recorder.record_page(message);
        }
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
            self.pauses.request(&text, now_ns);
            if self.repeats.is_new(&text, now_ns) {
                let text = format!("operator: {text}");
                self.log.operator(time_s, &text);
                self.broadcast.add_log_line(time_s, "lifecycle", &text);
            }
        }
    }

    /// Writes a pause that no page requested to the log and the page: a recording has it, too.
    fn log_pause(&mut self, until_ns: u64) {
        if let Some((text, time_s)) = self.pauses.take_due(until_ns) {
            let text = format!("operator: {text}");
            self.log.operator(time_s, &text);
            self.broadcast.add_log_line(time_s, "lifecycle", &text);
        }
    }

    fn drain(&mut self) {
        let (log, broadcast) = (&mut self.log, &self.broadcast);
        self.trace.take_all(|line| {
            log.line(line);
            broadcast.take_line(line);
        });
        // Reported as a line of the log: a gap must be visible where it is.
        let gaps = self.trace.counts().late;
        if gaps > self.gaps {
            let missing = gaps - self.gaps;
            self.log.gap(missing);
            let text = format!("[monitor] {missing} lines of the task were not read in time");
            let time_s = self.tick as f64 * TICK_NS as f64 / 1.0e9;
            broadcast.add_log_line(time_s, "lifecycle", &text);
            self.gaps = gaps;
        }
    }
}

impl Drop for MonitorProcess {
    fn drop(&mut self) {
        // An ending cell and a restarting monitor are different messages on the page.
        self.broadcast
            .close(if self.ending { "end" } else { "restart" });
    }
}
