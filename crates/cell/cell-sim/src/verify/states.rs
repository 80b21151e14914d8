//! Recorded states, assembled from their pieces.

use ipc_types::{MAX_OBJECTS, ObjectState, Wire, WorldPiece, WorldState};

use super::message_window::{Found, Key, MessageWindow, Missing, key};

/// A state as far as it was recorded.
pub(super) struct SeenState {
    /// Everything but the objects.
    piece: Box<WorldPiece>,
    /// The newest recorded state of each object.
    objects: Vec<ObjectState>,
    /// Whether this state itself has the object.
    named: Vec<bool>,
}

impl SeenState {
    /// Writes the state into `out`.
    pub(super) fn write(&self, out: &mut WorldState) {
        self.piece.put(out);
        let (known, beyond) = out
            .objects
            .split_at_mut(self.objects.len().min(MAX_OBJECTS));
        for (place, object) in known.iter_mut().zip(&self.objects) {
            *place = *object;
        }
        // Places beyond the objects of the cell are zero in a state of physics; values of
        // another state left in `out` would reach the task.
        beyond.fill(ObjectState::zeroed());
    }

    /// Writes everything but the objects, which a controller does not read.
    pub(super) fn write_arms(&self, out: &mut WorldState) {
        self.piece.put(out);
    }

    /// Whether every object was recorded in this very tick.
    pub(super) fn is_whole(&self) -> bool {
        self.named.iter().all(|named| *named)
    }

    /// Whether the objects that this state does not have were at rest from their last recorded
    /// state to `later`.
    fn rests_until(&self, later: &Self) -> bool {
        let objects = self.objects.iter().zip(&later.objects).zip(&self.named);
        self.objects.len() == later.objects.len()
            && objects
                .into_iter()
                .all(|((now, then), named)| *named || now.as_bytes() == then.as_bytes())
    }
}

/// All states, by generation and number.
#[derive(Default)]
pub(super) struct States {
    window: MessageWindow<SeenState>,
    objects: Vec<ObjectState>,
    /// The state being assembled, and the number of its next piece.
    coming: Option<(Key, SeenState, u32)>,
}

impl States {
    /// Stores a piece; returns the gap before the state that it completes.
    pub(super) fn put(&mut self, piece: &WorldPiece) -> Option<Missing> {
        let state = key(&piece.state);
        let count = (piece.object_count as usize).min(MAX_OBJECTS);
        if piece.piece == 0 {
            // Known states are kept as long as the number of objects is the same: a state names
            // only those that changed.
            if self.objects.len() != count {
                self.objects = vec![ObjectState::zeroed(); count];
            }
            let seen = SeenState {
                piece: Box::new(*piece),
                objects: Vec::new(),
                named: vec![false; count],
            };
            self.coming = Some((state, seen, 0));
        }
        // A piece whose predecessor was lost belongs to no state: its objects would be taken
        // for those of another tick.
        let (coming, mut seen, next) = self.coming.take()?;
        if coming != state || next != piece.piece {
            return None;
        }
        for object in piece.objects() {
            let index = object.index as usize;
            if let (Some(place), Some(named)) =
                (self.objects.get_mut(index), seen.named.get_mut(index))
            {
                *place = object.state;
                *named = true;
            }
        }
        if next + 1 < piece.pieces {
            self.coming = Some((coming, seen, next + 1));
            return None;
        }
        // Objects that no piece named keep their newest recorded state: between two tenth ticks
        // only touched and pulled objects are recorded (ADR 0012).
        seen.objects.clone_from(&self.objects);
        self.window.put(state, seen)
    }

    /// The state with `key`.
    pub(super) fn find(&self, key: Key) -> Found<'_, SeenState> {
        self.window.find(key)
    }

    /// Whether the objects that the state `key` does not have were at rest around it; `None`
    /// while the next whole state may still follow.
    pub(super) fn rests_around(&self, key: Key) -> Option<bool> {
        // Unknown counts as moved: then the decision is skipped and not reported as different.
        let Found::Here(state) = self.window.find(key) else {
            return Some(false);
        };
        let mut later = self.window.after(key);
        match later.find(|((generation, _), seen)| *generation != key.0 || seen.is_whole()) {
            Some(((generation, _), seen)) => Some(*generation == key.0 && state.rests_until(seen)),
            None if self.window.has_ended() => Some(false),
            None => None,
        }
    }

    /// Marks the end of the recording.
    pub(super) fn end(&mut self) {
        self.window.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Header;
    use ipc_types::tap::Pieces;

    fn send(states: &mut States, tick: u64, position: f64, lose: Option<u32>) -> Option<Missing> {
        let mut state = WorldState::zeroed();
        state.header = Header::caused_by::<WorldState>(tick);
        (state.header.generation, state.header.seq) = (1, tick + 1);
        state.object_count = 20;
        state.objects[17].pose.position[0] = position;
        let (mut pieces, mut piece) = (Pieces::of(&state, &[]), WorldPiece::zeroed());
        let mut missing = None;
        while pieces.write_next(&state, &mut piece) {
            if lose != Some(piece.piece) {
                missing = missing.or(states.put(&piece));
            }
        }
        missing
    }

    #[test]
    fn a_state_is_there_once_all_its_pieces_are() {
        let mut states = States::default();
        assert_eq!(send(&mut states, 10, 1.0, None), None);
        let mut out = WorldState::zeroed();
        if let Found::Here(seen) = states.find((1, 11)) {
            seen.write(&mut out);
        }
        assert_eq!(
            (out.header.tick, out.objects[17].pose.position[0]),
            (10, 1.0)
        );
        assert_eq!(send(&mut states, 20, 1.0, Some(1)), None);
        assert!(matches!(states.find((1, 21)), Found::NotYet));
        assert_eq!(send(&mut states, 21, 1.0, None).map(|m| m.count), Some(10));
        assert!(matches!(states.find((1, 21)), Found::Lost));
    }

    #[test]
    fn what_was_not_named_is_known_where_it_stood_still() {
        let mut states = States::default();
        for (tick, position) in [(10, 1.0), (13, 1.0), (20, 1.0), (24, 1.5), (30, 2.0)] {
            send(&mut states, tick, position, None);
            if tick == 13 {
                assert_eq!(states.rests_around((1, 14)), None);
            }
        }
        assert_eq!(states.rests_around((1, 14)), Some(true));
        assert_eq!(states.rests_around((1, 25)), Some(false));
    }
}
