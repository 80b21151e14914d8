//! Reads every message of the bus, for the checks.

use cell_bus::{BusError, Subscriber};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, Health, TraceLine, WorldState};

use crate::check::Seen;
use crate::model::Shared;

/// A reader of all topics that the checks look at.
pub(crate) struct Observer {
    state: Subscriber<WorldState>,
    decision: Subscriber<Decision>,
    trace: Subscriber<TraceLine>,
    arms: Vec<(Subscriber<ArmStatus>, Subscriber<ArmCommand>)>,
    healths: Vec<(Process, Subscriber<Health>)>,
}

impl Observer {
    /// Of the bus of `model`.
    ///
    /// # Errors
    /// When the bus has no such topics.
    pub(crate) fn new(model: &Shared) -> Result<Self, BusError> {
        let model = model.borrow();
        let bus = model.faithful_bus();
        let arm = |arm| {
            let status = bus.subscriber(TopicId::ArmStatus(arm))?;
            Ok((status, bus.subscriber(TopicId::ArmCommand(arm))?))
        };
        let health = |process| Ok((process, bus.subscriber(TopicId::Health(process))?));
        let processes = model.processes().into_iter();
        Ok(Self {
            state: bus.subscriber(TopicId::WorldState)?,
            decision: bus.subscriber(TopicId::Decision)?,
            trace: bus.subscriber(TopicId::Trace)?,
            arms: (0..model.spec.arms)
                .map(arm)
                .collect::<Result<_, BusError>>()?,
            healths: processes.map(health).collect::<Result<_, BusError>>()?,
        })
    }

    /// Passes what `process` sent in its turn to `each`.
    pub(crate) fn look(&mut self, process: Process, mut each: impl FnMut(Seen<'_>)) {
        match process {
            Process::Physics => {
                if let Some(state) = self.state.take() {
                    each(Seen::State(state));
                }
            }
            Process::Controller(arm) => self.look_at_arm(usize::from(arm), &mut each),
            Process::Task => {
                if let Some(decision) = self.decision.take() {
                    each(Seen::Decision(decision));
                }
                self.trace.take_all(|line| {
                    if line.kind == TraceKind::Lifecycle.code() {
                        each(Seen::Trace(line));
                    }
                });
            }
            Process::Monitor => {}
        }
        let mut healths = self.healths.iter_mut();
        let health = healths.find(|(of, _)| *of == process);
        if let Some(health) = health.and_then(|(_, health)| health.take()) {
            each(Seen::Health(process, health));
        }
    }

    fn look_at_arm(&mut self, arm: usize, each: &mut impl FnMut(Seen<'_>)) {
        let Some((status, command)) = self.arms.get_mut(arm) else {
            return;
        };
        if let Some(status) = status.take() {
            each(Seen::Status(arm, status));
        }
        if let Some(command) = command.take() {
            each(Seen::Command(arm, command));
        }
    }
}
