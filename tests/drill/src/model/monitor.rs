//! A monitor without page and recorder: it gives signs of life, and says how far it has recorded.

use cell_bus::{Bus, BusError, MemorySite, Publisher, Subscriber};
use cell_rt::Clock as _;
use cell_worker::{HealthReporter, Start, Turn, Wait, Woken};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Header, Health, WorldState};

pub(super) struct Monitor {
    state: Subscriber<WorldState>,
    progress: Publisher<Health>,
    health: HealthReporter,
    clock: MemorySite,
}

impl Monitor {
    pub(super) fn new(start: &Start, bus: &Bus, clock: MemorySite) -> Result<Self, BusError> {
        Ok(Self {
            state: bus.subscriber(TopicId::WorldState)?,
            progress: bus.publisher(TopicId::Recorder)?,
            health: HealthReporter::new(start, bus, Process::Monitor, false, clock.now_ns())?,
            clock,
        })
    }
}

impl Turn for Monitor {
    fn turn(&mut self, _: Woken) -> Wait {
        if let Some(state) = self.state.take() {
            let of = state.header;
            // The next message replaces one that was not sent.
            let _sent = self.progress.publish(|message| {
                message.header = Header::caused_by::<Health>(of.tick);
                message.header.push_input(ipc_types::header::Input {
                    topic: TopicId::WorldState.code(),
                    generation: of.generation,
                    seq: of.seq,
                    age_ticks: 0,
                });
            });
        }
        let now_ns = self.clock.now_ns();
        let tick = self.state.current().map_or(0, |state| state.header.tick);
        self.health.idle();
        self.health.publish_if_due(tick, now_ns);
        Wait::Bell
    }
}
