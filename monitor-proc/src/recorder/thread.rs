//! The thread of the recorder.
//!
//! What can go wrong: the bus cannot be joined, a tap overflows, the disk is full. The rules:
//! the recorder keeps its file open and tries the bus again; it reads often enough that no
//! buffer is full, and reports what was overwritten as a gap; the report for the launcher is
//! written before anything that can end this process.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use cell_bus::{Bus, BusError, RunSite};
use cell_rt::monotonic_ns;
use cell_run::record::RecordReport;
use cell_run::spec::RunSpec;
use ipc_types::topic::Process;
use serde_json::Value;

use super::hops::Hops;
use super::progress::Progress;
use super::report::Report;
use super::sink::Sink;
use super::taps::Taps;
use super::{Answer, QueuedRequest, RecorderRequest, RecorderStatus, Shared, lock};
use crate::feed::broadcast::RecordedSpan;

/// Pause between two readings in real time (ms), and at full speed. A task on a busy machine
/// sends a checkpoint with every decision, and sixteen of them can wait.
const PAUSE_MS: (f64, f64) = (100.0, 2.0);
/// Buffers are emptied at about this fill.
// Far below full: a pause of the machine of six times as long loses nothing.
const WANTED_FILL: f64 = 0.15;
/// Interval between attempts to join the bus.
const RETRY: Duration = Duration::from_millis(500);
/// Interval of status and latency (ns).
const REPORT_NS: u64 = 500_000_000;

/// Inputs of the thread.
pub(super) struct Job {
    pub(super) spec: RunSpec,
    pub(super) generation: u32,
    pub(super) scene: Value,
    pub(super) shared: Arc<Shared>,
    pub(super) requests: Receiver<QueuedRequest>,
    pub(super) page: Receiver<Value>,
}

/// Records until no request can arrive any more.
pub(super) fn run(job: &Job) {
    let mut sink = Sink::new(&job.spec, &job.scene);
    if let Some(file) = &job.spec.record.file {
        sink.start_run(file, job.generation);
    }
    let mut report = Report::new(&job.spec.run_dir, job.generation);
    // Before anything can end this process: the launcher finds the file at the end of the run.
    report.write(sink.report());
    while let Err(error) = listen(job, &mut sink, &mut report) {
        let note = format!("the recorder hears nothing: {error}");
        {
            let mut status = lock(&job.shared.status);
            status.state = "trouble";
            status.note.clone_from(&note);
        }
        report.write(RecordReport {
            error: Some(note),
            ..sink.report()
        });
        if !answer_until(job, &mut sink, RETRY) {
            break;
        }
    }
    put_page(job, &mut sink);
    sink.close();
    report.write(RecordReport {
        closed: true,
        ..sink.report()
    });
}

fn listen(job: &Job, sink: &mut Sink, report: &mut Report) -> Result<(), BusError> {
    let site = RunSite {
        root: job.spec.root.clone(),
        prefix: job.spec.prefix.clone(),
    };
    let name = Process::Monitor.name();
    let bus = Bus::join(&site, job.spec.run, job.generation, &name)?;
    let mut taps = Taps::new(&bus, job.spec.arms, &job.scene)?;
    let mut hops = Hops::new(usize::from(job.spec.arms));
    let mut progress = Progress::new(&bus)?;
    // Starts with the short pause: at full speed the first buffer may be full soon.
    let (mut pause_ms, mut report_due_ns) = (PAUSE_MS.1, 0);
    loop {
        let now_ns = monotonic_ns();
        sink.at(now_ns);
        let mut fill = taps.drain(sink, &mut hops, now_ns);
        put_page(job, sink);
        sink.flush_if_due();
        // Only in lockstep physics waits for it; in real time
        // the message would be for no reader.
        if let Some(state) = taps.newest().filter(|_| taps.is_lockstep()) {
            fill = fill.max(progress.report(state));
        }
        if now_ns >= report_due_ns {
            report_due_ns = now_ns + REPORT_NS;
            *lock(&job.shared.latency) = hops.report(now_ns);
            *lock(&job.shared.status) = status(job, sink);
            report.write(sink.report());
        }
        // The pause follows the fill of the last reading, within both limits.
        let wanted = pause_ms * WANTED_FILL / fill.max(1.0e-3);
        pause_ms = wanted.clamp(PAUSE_MS.1, PAUSE_MS.0);
        match job
            .requests
            .recv_timeout(Duration::from_secs_f64(pause_ms / 1.0e3))
        {
            Ok((request, answer)) => {
                sink.at(monotonic_ns());
                // Messages sent before the request belong to the recording.
                taps.drain(sink, &mut hops, now_ns);
                put_page(job, sink);
                execute(sink, &request, &answer);
                *lock(&job.shared.status) = status(job, sink);
                report.write(sink.report());
            }
            Err(RecvTimeoutError::Timeout) => {}
            // All senders are gone: the process ends, and the waiting
            // messages are the end of the recording.
            Err(RecvTimeoutError::Disconnected) => {
                taps.drain(sink, &mut hops, now_ns);
                return Ok(());
            }
        }
    }
}

/// Writes what the page was told beside the messages of the bus.
fn put_page(job: &Job, sink: &mut Sink) {
    for message in job.page.try_iter() {
        sink.put_page(message.to_string().as_bytes());
    }
}

/// Answers while there is no bus; false when no request can arrive any more.
fn answer_until(job: &Job, sink: &mut Sink, time: Duration) -> bool {
    put_page(job, sink);
    match job.requests.recv_timeout(time) {
        Ok((request, answer)) => {
            execute(sink, &request, &answer);
            true
        }
        Err(RecvTimeoutError::Timeout) => true,
        Err(RecvTimeoutError::Disconnected) => false,
    }
}

fn execute(sink: &mut Sink, request: &RecorderRequest, answer: &Answer) {
    let done = match request {
        RecorderRequest::Start { file } => sink.start(file),
        RecorderRequest::Stop => sink.stop(),
        RecorderRequest::Flush | RecorderRequest::Last { .. } => {
            sink.flush();
            match sink.flight().trouble() {
                Some(trouble) => Err(trouble.to_owned()),
                None => Ok("written down".to_owned()),
            }
        }
    };
    // The client may be gone.
    let _heard = answer.send(done).is_ok();
}

fn status(job: &Job, sink: &Sink) -> RecorderStatus {
    let flight = sink.flight();
    let (from_s, to_s) = flight.span_s();
    let trouble = sink.trouble();
    RecorderStatus {
        state: if trouble.is_some() { "trouble" } else { "on" },
        bytes: flight.bytes(),
        limit_bytes: job.spec.record.limit_bytes,
        file: sink.file(),
        gaps: sink.gaps(),
        note: trouble.unwrap_or_default().to_owned(),
        recorded_span: RecordedSpan {
            from_s,
            to_s,
            epochs: flight.epochs(),
        },
    }
}
