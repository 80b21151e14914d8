//! Sends the state to the recorder in pieces, after all others have it (ADR 0012).

use cell_bus::{Bus, BusError, Publisher};
use ipc_types::tap::Pieces;
use ipc_types::topic::TopicId;
use ipc_types::{Header, MAX_OBJECTS, ObjectState, Wire, WorldPiece, WorldState};

/// A copy of the newest state, and the way out for its pieces.
pub(crate) struct StateTap {
    state: Box<WorldState>,
    /// Objects of the state that was sent last.
    before: Vec<ObjectState>,
    pieces: Publisher<WorldPiece>,
}

impl StateTap {
    pub(crate) fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            state: Box::new(WorldState::zeroed()),
            before: Vec::with_capacity(MAX_OBJECTS),
            pieces: bus.publisher(TopicId::WorldTap)?,
        })
    }

    /// Connects a recorder that joined since the last state, and gives it that state.
    pub(crate) fn update_connections(&mut self) {
        self.pieces.update_connections();
    }

    /// Keeps a copy of the state that is being published.
    // A copy: the pieces are written after the loaned message was published.
    pub(crate) fn keep(&mut self, state: &WorldState) {
        self.state.copy_from(state);
    }

    /// Sends the kept state, under the header it was published with.
    pub(crate) fn publish(&mut self, header: &Header) {
        self.state.header = *header;
        let (state, mut pieces) = (&self.state, Pieces::of(&self.state, &self.before));
        let mut more = true;
        while more {
            // A piece that was not sent is a gap in the recording; the port counts it.
            let sent = self
                .pieces
                .publish(|piece| more = pieces.write_next(state, piece) && pieces.has_more());
            // After a piece that was refused the others would be as well: the tick is given
            // up.
            more &= sent.is_ok();
        }
        self.before.clear();
        self.before.extend_from_slice(self.state.objects());
    }
}
