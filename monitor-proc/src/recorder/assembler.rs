//! Combines states from their pieces.

use ipc_types::{Header, Wire, WorldPiece, WorldState};

/// The newest state with all its objects.
pub(super) struct StateAssembler {
    state: Box<WorldState>,
    /// The next piece expected; 0 if one is missing.
    next: u32,
}

impl StateAssembler {
    pub(super) fn new() -> Self {
        Self {
            state: Box::new(WorldState::zeroed()),
            next: 0,
        }
    }

    /// Takes a piece; returns the state if it was the last of one that names all objects and
    /// all its pieces arrived. A recorder that starts between two pieces has only the later
    /// ones.
    pub(super) fn take(&mut self, piece: &WorldPiece) -> Option<&WorldState> {
        // Other states name some objects only; the rest would be of older ticks.
        if piece.all_objects == 0 {
            return None;
        }
        let of = |header: &Header| (header.generation, header.seq, header.tick);
        let follows = piece.piece == self.next && of(&piece.state) == of(&self.state.header);
        // A gap: the state is given up, and the next first piece starts a new one.
        if piece.piece != 0 && !follows {
            self.next = 0;
            return None;
        }
        piece.put(&mut self.state);
        self.next = piece.piece + 1;
        if self.next != piece.pieces {
            return None;
        }
        // The publication of the last piece, so that messages made of it come after all pieces.
        self.state.header.publish_ns = piece.header.publish_ns;
        Some(&self.state)
    }
}

#[cfg(test)]
mod tests {
    use ipc_types::tap::Pieces;

    use super::*;

    /// The pieces of a state of 20 objects.
    fn pieces(tick: u64) -> Vec<WorldPiece> {
        let mut state = WorldState::zeroed();
        state.header = Header::caused_by::<WorldState>(tick);
        state.object_count = 20;
        for object in state.objects.iter_mut().take(20) {
            object.pose = ipc_types::Pose::IDENTITY;
        }
        let mut pieces = Pieces::of(&state, &[]);
        let mut out = Vec::new();
        while pieces.has_more() {
            let mut piece = WorldPiece::zeroed();
            pieces.write_next(&state, &mut piece);
            out.push(piece);
        }
        out
    }

    #[test]
    fn a_state_is_whole_with_all_its_pieces_and_not_before() {
        let mut states = StateAssembler::new();
        let first = pieces(10);
        assert_eq!(first.len(), 3);
        // The recorder started after the first piece.
        assert!(first[1..].iter().all(|piece| states.take(piece).is_none()));
        let second = pieces(20);
        assert!(second[..2].iter().all(|piece| states.take(piece).is_none()));
        let state = states.take(&second[2]).unwrap();
        assert!(
            state.objects().len() == 20
                && (state.objects().iter()).all(|o| o.pose == ipc_types::Pose::IDENTITY)
        );
        // One is missing, or is of another state.
        let (third, fourth) = (pieces(30), pieces(40));
        for piece in [&third[0], &third[2], &third[1], &fourth[2]] {
            assert!(states.take(piece).is_none());
        }
        assert!(fourth[..2].iter().all(|piece| states.take(piece).is_none()));
        assert!(states.take(&fourth[2]).is_some());
    }
}
