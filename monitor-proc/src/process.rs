//! The monitor on the bus: drain what was said, write it down.

use std::fs::File;
use std::time::Duration;

use cell_bus::{Bus, BusError, Sleeper, Subscriber};
use cell_rt::{monotonic_ns, signal::stop_requested};
use cell_worker::{HealthReporter, Start};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{TraceLine, WorldState};

use crate::journal::Journal;

/// Longest sleep between two looks.
const NUDGE: Duration = Duration::from_millis(5);

/// Why a monitor cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The log folder.
    #[error("logs of the run: {0}; check that the run directory belongs to you")]
    Journal(#[from] std::io::Error),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Runs the monitor until it is asked to stop.
///
/// # Errors
///
/// When the log cannot be opened or the bus cannot be joined.
pub fn run(start: &Start) -> Result<(), ProcessError> {
    let logs = start.spec.run_dir.join("logs");
    std::fs::create_dir_all(&logs)?;
    let journal = Journal::open(&logs)?;
    let bus = start.join(Process::Monitor)?;
    let mut process = MonitorProcess::new(&bus, journal)?;
    while !stop_requested() {
        process.turn();
    }
    // What was said last is still to be written.
    process.drain();
    Ok(())
}

struct MonitorProcess {
    journal: Journal<File>,
    trace: Subscriber<TraceLine>,
    state: Subscriber<WorldState>,
    gaps: u64,
    tick: u64,
    sleeper: Sleeper,
    health: HealthReporter,
}

impl MonitorProcess {
    fn new(bus: &Bus, journal: Journal<File>) -> Result<Self, BusError> {
        Ok(Self {
            journal,
            trace: bus.subscriber(TopicId::Trace)?,
            state: bus.subscriber(TopicId::WorldState)?,
            gaps: 0,
            tick: 0,
            sleeper: bus.sleeper(Process::Monitor)?,
            health: HealthReporter::new(bus, Process::Monitor, false)?,
        })
    }

    fn turn(&mut self) {
        let began_ns = monotonic_ns();
        self.drain();
        if let Some(state) = self.state.take() {
            self.tick = state.header.tick;
        }
        let now_ns = monotonic_ns();
        self.health.cycle(0, now_ns.saturating_sub(began_ns));
        let counts = self.trace.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        if self.journal.lost() > 0 {
            self.health.note(&format!(
                "the disk did not take {} lines of the log",
                self.journal.lost()
            ));
        }
        self.health.publish_if_due(self.tick, now_ns);
        self.sleeper.wait(NUDGE);
    }

    fn drain(&mut self) {
        let journal = &mut self.journal;
        self.trace.take_all(|line| journal.line(line));
        let gaps = self.trace.counts().late;
        if gaps > self.gaps {
            self.journal.gap(gaps - self.gaps);
            self.gaps = gaps;
        }
    }
}
