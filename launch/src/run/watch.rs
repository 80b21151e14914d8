//! What the launcher hears of the processes.

use cell_bus::{Bus, Latest};
use ipc_types::health::Scheduling;
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Decision, Health, WorldState};

use crate::failure::{Context, Failure};
use crate::supervisor::Event;

/// Health of one process, over its restarts.
struct Pulse {
    process: Process,
    latest: Latest<Health>,
    /// Missed cycles of the generations before.
    missed_before: u64,
    generation: u32,
    missed: u64,
}

/// The newest of everything the launcher looks at.
pub struct Watch {
    pulses: Vec<Pulse>,
    state: Latest<WorldState>,
    decision: Latest<Decision>,
}

impl Watch {
    /// Opens what is heard of `processes`.
    pub fn open(bus: &Bus, processes: &[Process]) -> Result<Self, Failure> {
        let what = "read the cell's topics";
        let pulse = |process: &Process| {
            let latest = bus.latest(TopicId::Health(*process)).cannot(what)?;
            Ok(Pulse {
                process: *process,
                latest,
                missed_before: 0,
                generation: 0,
                missed: 0,
            })
        };
        Ok(Self {
            pulses: processes
                .iter()
                .map(pulse)
                .collect::<Result<_, Failure>>()?,
            state: bus.latest(TopicId::WorldState).cannot(what)?,
            decision: bus.latest(TopicId::Decision).cannot(what)?,
        })
    }

    /// Takes what is new; health messages become events.
    pub fn poll(&mut self) -> Vec<Event> {
        // The state first: one that says the run ends was published after the
        // decision it ends with.
        self.state.refresh();
        self.decision.refresh();
        self.pulses.iter_mut().filter_map(Pulse::poll).collect()
    }

    /// The newest state of the world.
    pub fn state(&self) -> Option<&WorldState> {
        self.state.get()
    }

    /// The newest decision.
    pub fn decision(&self) -> Option<&Decision> {
        self.decision.get()
    }

    /// The newest health of a process.
    pub fn health(&self, process: Process) -> Option<&Health> {
        self.pulses
            .iter()
            .find(|p| p.process == process)?
            .latest
            .get()
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
    fn poll(&mut self) -> Option<Event> {
        if !self.latest.refresh() {
            return None;
        }
        let health = self.latest.get()?;
        if health.header.generation != self.generation {
            self.generation = health.header.generation;
            self.missed_before += self.missed;
        }
        self.missed = health.missed_cycles;
        Some(Event::Health {
            process: self.process,
            generation: health.header.generation,
            cycles: health.cycles,
            fifo: health.scheduling == Scheduling::Fifo.code(),
        })
    }
}
