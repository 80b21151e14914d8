//! The thread of the recorder.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use cell_bus::{Bus, BusError, RunSite};
use cell_model::runs::record::RecordReport;
use cell_model::runs::spec::RunSpec;
use cell_rt::monotonic_ns;
use ipc_types::topic::Process;
use serde_json::Value;

use super::hops::Hops;
use super::progress::Progress;
use super::report::Report;
use super::sink::Sink;
use super::taps::Taps;
use super::{Answer, Ask, RecorderRequest, RecorderStatus, Shared, lock};
use crate::hub::Timeline;

/// Pause between two looks in real time (ms), and when all runs as fast as it
/// can. A task on a busy machine sends a state record with every decision, and
/// sixteen of them can wait.
const PAUSE_MS: (f64, f64) = (100.0, 2.0);
/// Buffers are emptied when they are about this full.
const WANTED_FILL: f64 = 0.15;
/// Time between two attempts to join the bus.
const RETRY: Duration = Duration::from_millis(500);
/// How often status and latency are told (ns).
const TELL_NS: u64 = 500_000_000;

/// All the thread needs.
pub(super) struct Job {
    pub(super) spec: RunSpec,
    pub(super) generation: u32,
    pub(super) scene: Value,
    pub(super) shared: Arc<Shared>,
    pub(super) asked: Receiver<Ask>,
}

/// Records until no request can come any more.
pub(super) fn run(job: &Job) {
    let mut sink = Sink::new(&job.spec, &job.scene);
    if let Some(file) = &job.spec.record.file {
        sink.start_run(file, job.generation);
    }
    let mut report = Report::new(&job.spec.run_dir, job.generation);
    // Before anything can end this process: the file is named at the end of the run.
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
    let (mut pause_ms, mut told_ns) = (PAUSE_MS.1, 0);
    loop {
        let now_ns = monotonic_ns();
        sink.at(now_ns);
        let mut fill = taps.drain(sink, &mut hops, now_ns);
        sink.flush_if_due();
        if let Some(state) = taps.newest().filter(|_| taps.is_lockstep()) {
            fill = fill.max(progress.tell(state));
        }
        if now_ns >= told_ns {
            told_ns = now_ns + TELL_NS;
            *lock(&job.shared.latency) = hops.tell(now_ns);
            *lock(&job.shared.status) = status(job, sink);
            report.write(sink.report());
        }
        let wanted = pause_ms * WANTED_FILL / fill.max(1.0e-3);
        pause_ms = wanted.clamp(PAUSE_MS.1, PAUSE_MS.0);
        match job
            .asked
            .recv_timeout(Duration::from_secs_f64(pause_ms / 1.0e3))
        {
            Ok((request, answer)) => {
                sink.at(monotonic_ns());
                // What was said before the request belongs to it.
                taps.drain(sink, &mut hops, now_ns);
                obey(sink, &request, &answer);
                *lock(&job.shared.status) = status(job, sink);
                report.write(sink.report());
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                taps.drain(sink, &mut hops, now_ns);
                return Ok(());
            }
        }
    }
}

/// Answers for as long as there is no bus; false when no request can come any more.
fn answer_until(job: &Job, sink: &mut Sink, time: Duration) -> bool {
    match job.asked.recv_timeout(time) {
        Ok((request, answer)) => {
            obey(sink, &request, &answer);
            true
        }
        Err(RecvTimeoutError::Timeout) => true,
        Err(RecvTimeoutError::Disconnected) => false,
    }
}

fn obey(sink: &mut Sink, request: &RecorderRequest, answer: &Answer) {
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
        timeline: Timeline {
            from_s,
            to_s,
            epochs: flight.epochs(),
        },
    }
}
