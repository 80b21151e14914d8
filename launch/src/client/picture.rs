//! One coherent look at a running cell, for `status` and `top`.

use std::time::{Duration, Instant};

use cell_bus::{Bus, Latest};
use ipc_types::TICK_NS;
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_PAUSED;
use ipc_types::{ArmStatus, Decision, Health, WorldState};
use supervisor::failure::{Context, Failure};

use super::session::Session;

/// How long the first messages are waited for, and half of the time after which a process counts as
/// silent; health arrives at 100 Hz.
const PATIENCE: Duration = Duration::from_millis(500);

/// Keeps the newest of everything a person wants to see.
pub(crate) struct Picture {
    healths: Vec<(Process, Latest<Health>, Instant)>,
    state: Latest<WorldState>,
    /// By arm.
    statuses: Vec<Latest<ArmStatus>>,
    decision: Latest<Decision>,
    /// Keeps the ports alive.
    _bus: Bus,
}

impl Picture {
    pub(crate) fn open(session: &Session) -> Result<Self, Failure> {
        let bus = session.join()?;
        let what = "read the cell's topics";
        let mut healths = Vec::new();
        for process in Process::all(session.spec.arms) {
            // Dated now: a process is not silent before it could be heard.
            healths.push((
                process,
                bus.latest(TopicId::Health(process)).cannot(what)?,
                Instant::now(),
            ));
        }
        Ok(Self {
            healths,
            state: bus.latest(TopicId::WorldState).cannot(what)?,
            statuses: (0..session.spec.arms)
                .map(|arm| bus.latest(TopicId::ArmStatus(arm)).cannot(what))
                .collect::<Result<_, _>>()?,
            decision: bus.latest(TopicId::Decision).cannot(what)?,
            _bus: bus,
        })
    }

    /// Takes new messages.
    pub(crate) fn update(&mut self) {
        self.state.refresh();
        self.decision.refresh();
        for status in &mut self.statuses {
            status.refresh();
        }
        for (_, latest, at) in &mut self.healths {
            if latest.refresh() {
                *at = Instant::now();
            }
        }
    }

    /// Waits until all processes were heard, or for half a second.
    pub(crate) fn fill(&mut self) {
        let until = Instant::now() + PATIENCE;
        loop {
            self.update();
            let full = self
                .healths
                .iter()
                .all(|(_, latest, _)| latest.get().is_some());
            if (full && self.state.get().is_some() && self.decision.get().is_some())
                || Instant::now() > until
            {
                return;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// The number of each process's present start; none of one that was not heard.
    pub(crate) fn starts(&self) -> impl Iterator<Item = (Process, u32)> {
        self.healths.iter().map(|(process, health, _)| {
            let header = health.get().map(|health| health.header.generation);
            (*process, header.unwrap_or(0))
        })
    }

    pub(crate) fn state(&self) -> Option<&WorldState> {
        self.state.get()
    }

    /// By arm: what its controller says.
    pub(crate) fn said(&self) -> Vec<Option<&ArmStatus>> {
        self.statuses.iter().map(Latest::get).collect()
    }

    /// Simulated time in a second of wall time, of the last second; none while physics is
    /// silent.
    pub(crate) fn real_time_factor(&self) -> Option<f64> {
        let mut healths = self.healths();
        let physics = healths
            .find(|(process, _)| *process == Process::Physics)?
            .1?;
        let is_paused = self.state()?.has(FLAG_PAUSED);
        let tick_s = TICK_NS as f64 * 1.0e-9;
        // The loop of physics keeps its rate in a pause, without ticks.
        Some(if is_paused {
            0.0
        } else {
            physics.rate_hz * tick_s
        })
    }

    pub(crate) fn decision(&self) -> Option<&Decision> {
        self.decision.get()
    }

    /// Each process with its newest health, unless it has fallen silent.
    pub(crate) fn healths(&self) -> impl Iterator<Item = (Process, Option<&Health>)> {
        self.healths.iter().map(|(process, latest, at)| {
            let health = if at.elapsed() <= 2 * PATIENCE {
                latest.get()
            } else {
                None
            };
            (*process, health)
        })
    }
}
