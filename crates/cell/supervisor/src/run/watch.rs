//! What the launcher heard of the processes.

use ipc_types::health::Scheduling;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;
use ipc_types::{Decision, Health, WorldState};

use crate::supervision::Event;

/// Different faults that are told of one cell.
const MOST_FAULTS: usize = 20;

/// Messages that arrived since the launcher looked last.
#[derive(Default)]
pub struct News {
    /// The newest state of the world.
    pub state: Option<Box<WorldState>>,
    /// The newest decision.
    pub decision: Option<Box<Decision>>,
    /// The newest of each process that said something.
    pub healths: Vec<(Process, Box<Health>)>,
    /// How long the bus was listened to (ns).
    pub listened_ns: u64,
    /// The request that ended, and whether physics answered it.
    pub answer: Option<(OperatorAction, bool)>,
}

impl News {
    pub(super) fn add(&mut self, newer: Self) {
        self.state = newer.state.or(self.state.take());
        self.decision = newer.decision.or(self.decision.take());
        for (process, health) in newer.healths {
            self.healths.retain(|(other, _)| *other != process);
            self.healths.push((process, health));
        }
        self.listened_ns += newer.listened_ns;
        self.answer = newer.answer.or(self.answer);
    }
}

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
    /// Each fault that was reported, once, in the order of the reports.
    faults: Vec<String>,
    /// How many of them were told.
    told: usize,
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
            faults: Vec::new(),
            told: 0,
        }
    }

    /// The same, with the faults that were reported to `before`.
    pub(super) fn with_faults_of(self, before: &mut Self) -> Self {
        Self {
            faults: std::mem::take(&mut before.faults),
            told: before.told,
            ..self
        }
    }

    /// Takes new messages; those of the processes become events.
    pub(super) fn take(&mut self, news: News) -> Vec<Event> {
        self.state = news.state.or(self.state.take());
        self.decision = news.decision.or(self.decision.take());
        // Before the signs of life: they came during that time, which is long where this
        // thread was not scheduled. Silence is what no sign of life follows.
        let mut events = vec![Event::Listened {
            ns: news.listened_ns,
        }];
        for (process, health) in news.healths {
            self.note_fault(process, &health);
            let pulse = self.pulses.iter_mut().find(|p| p.process == process);
            events.extend(pulse.map(|pulse| pulse.take(health)));
        }
        events
    }

    fn note_fault(&mut self, process: Process, health: &Health) {
        let fault = health.fault();
        let fault = fault.map(|fault| format!("{}: {fault}", process.name()));
        let Some(fault) = fault.filter(|fault| !self.faults.contains(fault)) else {
            return;
        };
        // A process that reports a new number with each fault must not fill the summary.
        match self.faults.len() + 1 {
            count if count < MOST_FAULTS => self.faults.push(fault),
            MOST_FAULTS => self
                .faults
                .push("more faults; see `robocell logs`".to_owned()),
            _ => {}
        }
    }

    /// Faults that processes reported since the start of the cell.
    pub(super) fn faults(&self) -> &[String] {
        &self.faults
    }

    /// The next fault that was not told yet.
    pub(super) fn next_fault(&mut self) -> Option<String> {
        let fault = self.faults.get(self.told)?.clone();
        self.told += 1;
        Some(fault)
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
        // A successor counts its missed cycles from 0.
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

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Header, Text, Wire};

    use crate::supervision::{Action, Rules, Supervisor};

    /// What a launcher hears that was not scheduled for `gap_ns`, while the processes
    /// worked.
    fn news(cycles: u64, gap_ns: u64) -> News {
        let mut health = Health::zeroed();
        health.header = Header {
            generation: 1,
            ..Header::caused_by::<Health>(cycles)
        };
        (health.cycles, health.scheduling) = (cycles, Scheduling::Fifo.code());
        News {
            healths: vec![(Process::Physics, Box::new(health))],
            listened_ns: gap_ns,
            ..News::default()
        }
    }

    #[test]
    fn a_fault_is_told_once_though_its_process_is_replaced_and_is_kept_for_the_summary() {
        let mut watch = Watch::new(&[Process::Physics]);
        let mut told = Vec::new();
        let fault = "fault: its state is not kept: 70000000 bytes";
        for note in ["tick 7 waits for task", fault, fault, "", fault] {
            let mut news = news(10, 5_000_000);
            news.healths[0].1.note = Text::new(note);
            watch.take(news);
            told.extend(watch.next_fault());
        }
        assert_eq!(told, ["physics: its state is not kept: 70000000 bytes"]);
        assert_eq!(watch.faults(), told);
    }

    #[test]
    fn a_launcher_that_was_not_scheduled_takes_no_process_for_hung() {
        let rules = Rules {
            watchdog: true,
            lockstep: false,
            python_task: false,
        };
        let mut supervisor = Supervisor::new(&[Process::Physics], rules);
        let mut watch = Watch::new(&[Process::Physics]);
        let mut actions = Vec::new();
        supervisor.poll(0, &mut actions);
        for (step, gap_ns) in [5_000_000, 5_000_000, 300_000_000, 5_000_000]
            .into_iter()
            .enumerate()
        {
            let step = step as u64;
            for event in watch.take(news(10 * (step + 1), gap_ns)) {
                supervisor.handle(step, event, &mut actions);
            }
            supervisor.poll(step, &mut actions);
        }
        let killed = actions
            .iter()
            .any(|action| matches!(action, Action::Kill { .. }));
        assert!(!killed, "{actions:?}");
        // Silence is noticed all the same.
        for step in 10..40 {
            let silent = News {
                listened_ns: 10_000_000,
                ..News::default()
            };
            for event in watch.take(silent) {
                supervisor.handle(step, event, &mut actions);
            }
            supervisor.poll(step, &mut actions);
        }
        let killed = actions
            .iter()
            .any(|action| matches!(action, Action::Kill { .. }));
        assert!(killed, "{actions:?}");
    }
}
