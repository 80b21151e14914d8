//! Inputs of the client on their way into the cycle, each with its copy for the recorder.

use cell_bus::Publisher;
use fci::REQUEST_BYTES;
use ipc_types::client::{CLIENT_BYTES, ClientEvent};
use ipc_types::{ClientInput, Wire, WorldState};

use crate::cycle::Cycle;
use crate::messages;

const _: () = assert!(REQUEST_BYTES <= CLIENT_BYTES, "a request would be cut");

/// The inputs of the client.
pub(super) struct Inputs {
    tap: Publisher<ClientInput>,
    input: ClientInput,
    /// States that were sent again since the last input.
    repeats: u32,
}

impl Inputs {
    pub(super) fn new(arm: u8, tap: Publisher<ClientInput>) -> Self {
        let mut input = ClientInput::zeroed();
        input.arm = u32::from(arm);
        Self {
            tap,
            input,
            repeats: 0,
        }
    }

    /// Gives `cycle` an input of the client, with the bytes that were received.
    // The cycle reads the message that is recorded, not the values behind it: a replay does the
    // same.
    pub(super) fn take(
        &mut self,
        cycle: &mut Cycle,
        state: Option<&WorldState>,
        (event, is_awaited): (ClientEvent, bool),
        bytes: &[u8],
    ) {
        let input = &mut self.input;
        if let Some(state) = state {
            input.header = messages::caused_by::<ClientInput>((state, None));
        }
        input.event = event.code();
        input.repeats = std::mem::take(&mut self.repeats);
        input.is_awaited = u32::from(is_awaited);
        input.len = u32::try_from(bytes.len()).unwrap_or(0);
        for (to, from) in input.bytes.iter_mut().zip(bytes) {
            *to = *from;
        }
        if self.tap.publish_copy(input).is_ok() {
            input.header = *self.tap.header();
        }
        cycle.take(input, state);
    }

    /// The present state was sent again, which `cycle` counts at once.
    pub(super) fn repeat(&mut self, cycle: &mut Cycle) {
        self.repeats += 1;
        cycle.repeat(1);
    }

    /// Before a cycle: records the repeats since the last input.
    pub(super) fn settle(&mut self, cycle: &mut Cycle, state: Option<&WorldState>) {
        if self.repeats > 0 {
            self.take(cycle, state, (ClientEvent::None, false), &[]);
        }
    }

    /// Lets a recorder in that joined since the last input.
    pub(super) fn update_connections(&mut self) {
        self.tap.update_connections();
    }
}
