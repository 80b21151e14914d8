//! Incidents: when a process or an arm fails, the last cycles of every loop, the end of
//! the log and the state files of the process are kept, before a successor starts.

mod draft;

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, channel, sync_channel};
use std::time::{Duration, SystemTime};

use cell_rt::priority::set_other;
use cell_run::incident::{Event, Head, Incident, Incidents, LogTail, ring_path};
use cell_run::spec::RunSpec;
use ipc_types::topic::Process;

use crate::child::last_words;
use crate::lock::utc;
use crate::run::watch::Watch;
use crate::rundir::{DEFAULT_CELL, RunDir};
use crate::say;
use draft::{Draft, ms, write_all};

/// How long after its first event an incident ends (ns).
const AFTER_NS: u64 = 1_000_000_000;
/// Events of one incident.
const EVENTS: usize = 64;
/// Lines of a log.
const LINES: usize = 40;
/// Largest state file that is kept (bytes).
const STATE_FILE: u64 = 8 << 20;
/// Drafts that wait for a disk; while it takes no more, newer ones are not kept.
const DRAFTS: usize = 8;
/// How long the end of a run waits for a disk.
const WRITE_LIMIT: Duration = Duration::from_secs(2);

/// Keeps the incidents of one run. Slow work is done by a thread of its own.
pub(crate) struct IncidentRecorder {
    dir: RunDir,
    processes: Vec<Process>,
    head: Head,
    recording: PathBuf,
    open: Option<Open>,
    /// Time of the newest state (s).
    sim_time_s: f64,
    /// Which start of each process worked last, in the order of `processes`.
    generations: Vec<u32>,
    /// Events of each process of which an incident was kept, with its start.
    reported: Vec<(u32, u64)>,
    faults: u32,
    writer: SyncSender<Draft>,
    done: Receiver<()>,
    /// Whether it was said that the disk is slow, and that a file is too long.
    said_full: bool,
    said_large: bool,
}

/// An incident of which the second after it is not over.
struct Open {
    first_ns: u64,
    events: Vec<Event>,
    about: Vec<Process>,
}

impl IncidentRecorder {
    /// Of a run of `processes` in `dir`.
    pub(crate) fn new(spec: &RunSpec, dir: &RunDir, processes: &[Process]) -> Self {
        let incidents = Incidents::at(spec.incidents_dir.clone());
        let newest = incidents.numbers().last().copied().unwrap_or(0);
        let (writer, drafts) = sync_channel(DRAFTS);
        let (finished, done) = channel();
        let work = move || {
            // The launcher's priority is not for a disk.
            set_other().ok();
            write_all(&incidents, &drafts);
            finished.send(()).ok();
        };
        let thread = std::thread::Builder::new().name("incidents".to_owned());
        if let Err(error) = thread.spawn(work) {
            say::warn(format_args!("incidents are not kept: {error}"));
        }
        Self {
            dir: dir.clone(),
            processes: processes.to_vec(),
            head: Head {
                number: newest,
                also: Vec::new(),
                what: String::new(),
                at: String::new(),
                sim_time_s: 0.0,
                run: spec.run,
                demo: spec.demo.clone(),
                policy: spec.policy.clone(),
                seed: spec.seed,
                version: env!("CARGO_PKG_VERSION").to_owned(),
                complete: false,
            },
            recording: spec.record.flight_dir.clone(),
            open: None,
            sim_time_s: 0.0,
            generations: vec![1; processes.len()],
            reported: vec![(1, 0); processes.len()],
            faults: 0,
            writer,
            done,
            said_full: false,
            said_large: false,
        }
    }

    /// `process` failed, in words. The number of the incident that has it.
    pub(crate) fn failed(&mut self, now_ns: u64, process: Process, what: &str) -> u32 {
        let is_first = self.open.is_none();
        if is_first {
            self.head.number += 1;
            what.clone_into(&mut self.head.what);
            self.head.also.clear();
            self.head.at = wall_clock();
            // Once: while the incident is open, simulated time continues.
            self.head.sim_time_s = self.sim_time_s;
            self.head.complete = false;
        } else {
            self.head.also.push(what.to_owned());
        }
        let open = self.open.get_or_insert_with(|| Open {
            first_ns: now_ns,
            events: Vec::new(),
            about: Vec::new(),
        });
        open.add(now_ns, what.to_owned());
        if !open.about.contains(&process) {
            open.about.push(process);
        }
        // Written now and when it is complete: a successor replaces the state file.
        let state_file = match process {
            Process::Task => Some("task.slots"),
            Process::Physics => Some("physics.state"),
            _ => None,
        };
        let files = state_file.and_then(|name| Some((name, self.state_file(name)?)));
        self.write(files.into_iter().collect());
        self.head.number
    }

    /// Takes note of what was heard, and completes an incident when its time is over.
    pub(crate) fn turn(&mut self, now_ns: u64, watch: &Watch) {
        if let Some(state) = watch.state() {
            self.sim_time_s = state.header.sim_time_ns as f64 * 1.0e-9;
            let count = (state.arm_count as usize).min(state.arms.len());
            let at_fault = |arm: &usize| state.arms[*arm].fault != 0;
            let faults = (0..count)
                .filter(at_fault)
                .fold(0, |bits, arm| bits | 1 << arm);
            let new = faults & !std::mem::replace(&mut self.faults, faults);
            for arm in (0..count).filter(|arm| new >> arm & 1 == 1) {
                let what = format!("arm {arm} is at fault until the scene is reset");
                let number = self.failed(now_ns, Process::Physics, &what);
                say::warn(format_args!("{what}; {}", self.hint(number)));
            }
        }
        self.take_reported(now_ns, watch);
        for (index, process) in self.processes.iter().enumerate() {
            let generation = watch.health(*process).map_or(0, |h| h.header.generation);
            if generation > self.generations[index] {
                self.generations[index] = generation;
                if let Some(open) = &mut self.open {
                    let name = process.name();
                    open.add(now_ns, format!("{name} works again, start {generation}"));
                }
            }
        }
        let over = |open: &Open| now_ns.saturating_sub(open.first_ns) > AFTER_NS;
        if self.open.as_ref().is_some_and(over) {
            self.complete();
        }
    }

    /// Keeps an incident of each event that a process reports, as a reflex of an arm.
    fn take_reported(&mut self, now_ns: u64, watch: &Watch) {
        for index in 0..self.processes.len() {
            let process = self.processes[index];
            let Some(health) = watch.health(process) else {
                continue;
            };
            let generation = health.header.generation;
            // A successor counts its events from 0.
            let known = if self.reported[index].0 == generation {
                self.reported[index].1
            } else {
                0
            };
            self.reported[index] = (generation, health.incidents);
            if health.incidents > known {
                let what = format!("{}: {}", process.name(), health.note.as_str());
                let number = self.failed(now_ns, process, &what);
                say::warn(format_args!("{what}; {}", self.hint(number)));
            }
        }
    }

    /// How an incident is looked at.
    pub(crate) fn hint(&self, number: u32) -> String {
        let cell = self.dir.path().file_name().unwrap_or_default();
        match cell.to_str() {
            Some(cell) if cell != DEFAULT_CELL => {
                format!("`robocell incident {number} --cell {cell}` shows it")
            }
            _ => format!("`robocell incident {number}` shows it"),
        }
    }

    /// The run ends: an open incident is written, if the disk takes it in time.
    pub(crate) fn end(mut self) {
        if self.open.is_some() {
            self.complete();
        }
        let Self { writer, done, .. } = self;
        drop(writer);
        if done.recv_timeout(WRITE_LIMIT).is_err() {
            say::warn("the last incident could not be written within 2 s");
        }
    }

    fn complete(&mut self) {
        self.head.complete = true;
        self.write(Vec::new());
        self.open = None;
    }

    /// Hands the incident, as it is now, to the writer.
    fn write(&mut self, files: Vec<(&'static str, Vec<u8>)>) {
        let Some(open) = &self.open else {
            return;
        };
        let ring = |process: &Process| {
            let path = ring_path(self.dir.path(), &process.name());
            (*process, path)
        };
        let log = |process: &Process| LogTail {
            process: process.name(),
            lines: last_words(&self.dir.log(&process.name()), LINES),
        };
        let draft = Draft {
            incident: Incident {
                head: self.head.clone(),
                events: open.events.clone(),
                loops: Vec::new(),
                logs: open.about.iter().map(log).collect(),
                recording: self.recording.clone(),
            },
            first_ns: open.first_ns,
            rings: self.processes.iter().map(ring).collect(),
            files,
        };
        // Without its thread, which was said, nothing is kept.
        if let Err(TrySendError::Full(draft)) = self.writer.try_send(draft)
            && !std::mem::replace(&mut self.said_full, true)
        {
            say::warn(format_args!(
                "incident {} and later ones may be incomplete: {DRAFTS} wait for the disk",
                draft.incident.head.number
            ));
        }
    }

    fn state_file(&mut self, name: &str) -> Option<Vec<u8>> {
        let path = self.dir.path().join(name);
        let bytes = std::fs::metadata(&path).ok()?.len();
        if bytes <= STATE_FILE {
            return std::fs::read(path).ok();
        }
        if !std::mem::replace(&mut self.said_large, true) {
            say::warn(format_args!(
                "{name} has {bytes} bytes: an incident keeps state files of at most {STATE_FILE}"
            ));
        }
        None
    }
}

impl Open {
    /// Adds an event; the last that fits says that there were more.
    fn add(&mut self, now_ns: u64, what: String) {
        let what = match self.events.len() {
            count if count + 1 < EVENTS => what,
            count if count < EVENTS => format!("more events; {} are kept", EVENTS - 1),
            _ => return,
        };
        let at_ms = ms(now_ns, self.first_ns);
        self.events.push(Event { at_ms, what });
    }
}

#[expect(
    clippy::disallowed_methods,
    reason = "people compare it with their clock; nothing is computed with it"
)]
fn wall_clock() -> String {
    utc(SystemTime::now())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_that_are_not_kept_are_reported_as_the_last_one() {
        let mut open = Open {
            first_ns: 0,
            events: Vec::new(),
            about: Vec::new(),
        };
        for number in 0..EVENTS + 10 {
            open.add(0, format!("event {number}"));
        }
        assert_eq!(open.events.len(), EVENTS);
        assert_eq!(open.events[EVENTS - 2].what, "event 62");
        assert_eq!(open.events[EVENTS - 1].what, "more events; 63 are kept");
    }
}
