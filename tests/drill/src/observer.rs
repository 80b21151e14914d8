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
        let bus = model.bus(1);
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

    /// Passes what was sent since the last call to `each`: a state after the messages it was
    /// made from.
    pub(crate) fn look(&mut self, mut each: impl FnMut(Seen<'_>)) {
        if let Some(decision) = self.decision.take() {
            each(Seen::Decision(decision));
        }
        for (arm, (status, command)) in self.arms.iter_mut().enumerate() {
            if let Some(status) = status.take() {
                each(Seen::Status(arm, status));
            }
            if let Some(command) = command.take() {
                each(Seen::Command(arm, command));
            }
        }
        self.trace.take_all(|line| {
            if line.kind == TraceKind::Lifecycle.code() {
                each(Seen::Trace(line));
            }
        });
        if let Some(state) = self.state.take() {
            each(Seen::State(state));
        }
        for (process, health) in &mut self.healths {
            if let Some(health) = health.take() {
                each(Seen::Health(*process, health));
            }
        }
    }
}
