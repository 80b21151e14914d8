//! Tells physics how far the recorder has got.

use cell_bus::{Bus, BusError, Doorbell, Publisher};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Header, Health, Input, RECORDER_LAG_TICKS};

/// The recorder's word to physics, which in lockstep waits for it.
pub(super) struct Progress {
    port: Publisher<Health>,
    physics: Doorbell,
    /// Generation of physics and tick told last.
    told: (u32, u64),
}

impl Progress {
    pub(super) fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            port: bus.publisher(TopicId::Recorder)?,
            physics: bus.doorbell(Process::Physics)?,
            told: (0, 0),
        })
    }

    /// All up to the state with this header is taken down. How much of what physics
    /// may run ahead that was, 0 to 1.
    pub(super) fn tell(&mut self, state: &Header) -> f64 {
        let newest = (state.generation, state.tick);
        if newest == self.told {
            self.port.update_connections();
            return 0.0;
        }
        let ticks = newest.1.saturating_sub(self.told.1);
        let same = newest.0 == self.told.0;
        self.told = newest;
        let mut header = Header::caused_by::<Health>(state.tick);
        header.push_input(Input {
            topic: TopicId::WorldState.code(),
            generation: state.generation,
            seq: state.seq,
            age_ticks: 0,
        });
        // A word that was not sent is followed by another.
        let sent = self.port.publish(|message| {
            *message = ipc_types::Wire::zeroed();
            message.header = header;
        });
        if sent.is_ok() {
            self.physics.ring();
        }
        if same {
            ticks as f64 / RECORDER_LAG_TICKS as f64
        } else {
            0.0
        }
    }
}
