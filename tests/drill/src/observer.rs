//! Reads every message of the bus, for the checks.

use cell_bus::{Bus, BusError, Subscriber};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::TraceKind;
use ipc_types::{ArmCommand, ArmStatus, Decision, Header, Health, TraceLine, WorldState};

use crate::check::Seen;
use crate::model::Shared;
use crate::plan::{self, Fault, Plan};

/// A reader of all topics that the checks look at.
pub(crate) struct Observer {
    state: Subscriber<WorldState>,
    decision: Subscriber<Decision>,
    trace: Subscriber<TraceLine>,
    arms: Vec<(Subscriber<ArmStatus>, Subscriber<ArmCommand>)>,
    healths: Vec<(Process, Subscriber<Health>)>,
    bystanders: Vec<(TopicId, Bystander)>,
}

/// A reader that does nothing with the messages, as one that records or shows them. What a process
/// does with a message that comes again or late, it may refuse for another reason.
enum Bystander {
    State(Subscriber<WorldState>),
    Decision(Subscriber<Decision>),
    Status(Subscriber<ArmStatus>),
    Command(Subscriber<ArmCommand>),
    Health(Subscriber<Health>),
}

impl Bystander {
    fn new(bus: &Bus, topic: TopicId) -> Result<Option<Self>, BusError> {
        Ok(Some(match topic {
            TopicId::WorldState => Self::State(bus.subscriber(topic)?),
            TopicId::Decision => Self::Decision(bus.subscriber(topic)?),
            TopicId::ArmStatus(_) => Self::Status(bus.subscriber(topic)?),
            TopicId::ArmCommand(_) => Self::Command(bus.subscriber(topic)?),
            TopicId::Health(_) => Self::Health(bus.subscriber(topic)?),
            _ => return Ok(None),
        }))
    }

    /// Passes the headers of all messages that it uses now to `each`. It looks twice: a message
    /// may come again after it was taken.
    fn look(&mut self, mut each: impl FnMut(&Header)) {
        for _ in 0..2 {
            match self {
                Self::State(reader) => reader.take_all(|message| each(&message.header)),
                Self::Decision(reader) => reader.take_all(|message| each(&message.header)),
                Self::Status(reader) => reader.take_all(|message| each(&message.header)),
                Self::Command(reader) => reader.take_all(|message| each(&message.header)),
                Self::Health(reader) => reader.take_all(|message| each(&message.header)),
            };
        }
    }
}

/// The topics on which `plan` repeats messages, or lets them be late.
fn disturbed(plan: &Plan, arms: u8) -> Vec<TopicId> {
    let topic = |fault: &Fault| match fault {
        Fault::Repeat { topic, .. } | Fault::Late { topic, .. } => plan::topic(topic, arms),
        _ => None,
    };
    let of = plan.faults.iter().filter_map(|timed| topic(&timed.fault));
    let mut topics: Vec<TopicId> = of.collect();
    topics.sort_by_key(|topic| topic.code());
    topics.dedup();
    topics
}

impl Observer {
    /// Of the bus of `model`, on which `plan` disturbs messages.
    ///
    /// # Errors
    /// When the bus has no such topics.
    pub(crate) fn new(model: &Shared, plan: &Plan) -> Result<Self, BusError> {
        let model = model.borrow();
        let disturbed = disturbed(plan, model.spec.arms);
        let mut bystanders = Vec::new();
        for topic in disturbed {
            let bystander = Bystander::new(&model.readers_bus(), topic)?;
            bystanders.extend(bystander.map(|bystander| (topic, bystander)));
        }
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
            bystanders,
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
        for (topic, bystander) in &mut self.bystanders {
            bystander.look(|header| each(Seen::Used(*topic, header)));
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
