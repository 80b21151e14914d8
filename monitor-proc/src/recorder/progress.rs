//! Reports the progress of the recorder to physics.

use cell_bus::{Bus, BusError, Doorbell, Publisher};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{Header, Health, Input, RECORDER_LAG_TICKS};

/// The port to physics, which waits for the recorder in lockstep.
pub(super) struct Progress {
    port: Publisher<Health>,
    physics: Doorbell,
    /// Generation of physics and tick reported last.
    reported: (u32, u64),
}

impl Progress {
    pub(super) fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            port: bus.publisher(TopicId::Recorder)?,
            physics: bus.doorbell(Process::Physics)?,
            reported: (0, 0),
        })
    }

    /// Reports that everything up to the state with this header is recorded. Returns the share
    /// of the allowed lag that this was, 0 to 1.
    pub(super) fn report(&mut self, state: &Header) -> f64 {
        let newest = (state.generation, state.tick);
        if newest == self.reported {
            // Also without progress: physics may have restarted and joined since.
            self.port.update_connections();
            return 0.0;
        }
        let ticks = newest.1.saturating_sub(self.reported.1);
        let same = newest.0 == self.reported.0;
        self.reported = newest;
        let mut header = Header::caused_by::<Health>(state.tick);
        header.push_input(Input {
            topic: TopicId::WorldState.code(),
            generation: state.generation,
            seq: state.seq,
            age_ticks: 0,
        });
        // A message that was not sent is followed by another one.
        let sent = self.port.publish(|message| {
            *message = ipc_types::Wire::zeroed();
            message.header = header;
        });
        // Physics sleeps in lockstep until this ring.
        if sent.is_ok() {
            self.physics.ring();
        }
        // After a restart of physics the ticks of both generations cannot be compared.
        if same {
            ticks as f64 / RECORDER_LAG_TICKS as f64
        } else {
            0.0
        }
    }
}
