//! What the launcher heard of the processes.

use ipc_types::health::Scheduling;
use ipc_types::topic::Process;
use ipc_types::{Decision, Health, WorldState};

use super::bus_thread::News;
use crate::supervisor::Event;

/// Health of one process, over its restarts.
struct Pulse {
    process: Process,
    newest: Option<Box<Health>>,
    /// Missed cycles of the generations before.
    missed_before: u64,
    generation: u32,
    missed: u64,
}

/// The newest of everything the launcher looks at.
pub struct Watch {
    pulses: Vec<Pulse>,
    state: Option<Box<WorldState>>,
    decision: Option<Box<Decision>>,
}

impl Watch {
    /// Of `processes`, of which nothing was heard yet.
    pub(super) fn new(processes: &[Process]) -> Self {
        let pulse = |process: &Process| Pulse {
            process: *process,
            newest: None,
            missed_before: 0,
            generation: 0,
            missed: 0,
        };
        Self {
            pulses: processes.iter().map(pulse).collect(),
            state: None,
            decision: None,
        }
    }

    /// Takes what is new; what it says of the processes becomes events.
    pub(super) fn take(&mut self, news: News) -> Vec<Event> {
        self.state = news.state.or(self.state.take());
        self.decision = news.decision.or(self.decision.take());
        let mut events = Vec::new();
        for (process, health) in news.healths {
            let pulse = self.pulses.iter_mut().find(|p| p.process == process);
            events.extend(pulse.map(|pulse| pulse.take(health)));
        }
        // After the signs of life: what is left is silence.
        events.push(Event::Listened {
            ns: news.listened_ns,
        });
        events
    }

    /// The newest state of the world.
    pub fn state(&self) -> Option<&WorldState> {
        self.state.as_deref()
    }

    /// The newest decision.
    pub fn decision(&self) -> Option<&Decision> {
        self.decision.as_deref()
    }

    /// The newest health of a process.
    pub fn health(&self, process: Process) -> Option<&Health> {
        let pulse = self.pulses.iter().find(|p| p.process == process)?;
        pulse.newest.as_deref()
    }

    /// Missed cycles of all controllers since the start of the cell.
    pub fn missed_cycles(&self) -> u64 {
        let of_controllers = self
            .pulses
            .iter()
            .filter(|p| matches!(p.process, Process::Controller(_)));
        of_controllers.map(|p| p.missed_before + p.missed).sum()
    }
}

impl Pulse {
    fn take(&mut self, health: Box<Health>) -> Event {
        if health.header.generation != self.generation {
            self.generation = health.header.generation;
            self.missed_before += self.missed;
        }
        self.missed = health.missed_cycles;
        let event = Event::Health {
            process: self.process,
            generation: health.header.generation,
            cycles: health.cycles,
            fifo: health.scheduling == Scheduling::Fifo.code(),
        };
        self.newest = Some(health);
        event
    }
}
