//! States in pieces for the recorder: a replay has only what arrives in them.

use ipc_types::tap::{PIECE_OBJECTS, Pieces};
use ipc_types::world::{OBJECT_DRAGGED, OBJECT_OBSTACLE};
use ipc_types::{Header, MAX_OBJECTS, Validate as _, Wire as _, WorldPiece, WorldState};

/// A state of which each byte of each field is another than in a state of zeros.
fn full(tick: u64, objects: u32) -> WorldState {
    let bytes: Vec<u8> = (0..size_of::<WorldState>())
        .map(|at| u8::try_from(at % 251).unwrap() + 1)
        .collect();
    let mut state = WorldState::from_bytes(&bytes).unwrap();
    state.header.tick = tick;
    state.object_count = objects;
    for object in state.objects.iter_mut().skip(objects as usize) {
        *object = WorldState::zeroed().objects[0];
    }
    for object in &mut state.objects {
        object.flags = 0;
    }
    state
}

/// The state that a reader of the pieces has, if it had `before`; and their number.
fn heard(sent: &WorldState, before: &WorldState) -> (WorldState, u32) {
    let mut pieces = Pieces::of(sent, before.objects());
    let (mut piece, mut state, mut count) = (WorldPiece::zeroed(), *before, 0);
    while pieces.write_next(sent, &mut piece) {
        assert_eq!(piece.header.tick, sent.header.tick);
        piece.put(&mut state);
        count += 1;
    }
    assert!(!pieces.has_more());
    (state, count)
}

#[test]
fn no_field_of_a_state_is_lost_on_its_way_to_the_recorder() {
    let most = u32::try_from(MAX_OBJECTS).unwrap();
    for objects in [0, 1, 8, 9, most] {
        let sent = full(20, objects);
        let (state, count) = heard(&sent, &WorldState::zeroed());
        assert!(state.as_bytes() == sent.as_bytes(), "{objects} objects");
        let room = u32::try_from(PIECE_OBJECTS).unwrap();
        assert_eq!(count, objects.div_ceil(room).max(1), "{objects} objects");
    }
}

#[test]
fn between_two_decisions_only_what_controllers_use_is_recorded() {
    let before = full(20, 12);
    let mut sent = full(21, 12);
    for object in &mut sent.objects[..12] {
        object.pose.position[0] = 0.25;
    }
    sent.objects[3].flags = OBJECT_DRAGGED;
    sent.objects[5].flags = OBJECT_OBSTACLE;
    let (state, count) = heard(&sent, &before);
    assert_eq!(count, 1);
    let moved: Vec<usize> = (0..12)
        .filter(|index| state.objects[*index].pose.position[0] == 0.25)
        .collect();
    assert_eq!(moved, [3, 5]);
    // Of an obstacle that did not move nothing is sent again.
    let mut next = sent;
    next.header.tick = 22;
    next.objects[5].pose.position[0] = 0.25;
    let mut piece = WorldPiece::zeroed();
    assert!(Pieces::of(&next, sent.objects()).write_next(&next, &mut piece));
    let named: Vec<u32> = piece.objects().iter().map(|object| object.index).collect();
    assert_eq!(named, [3]);
    // The first state of a recorder names it all the same.
    assert!(Pieces::of(&next, &[]).write_next(&next, &mut piece));
    assert_eq!(piece.objects().len(), 2);
}

#[test]
fn a_damaged_piece_is_refused_and_writes_nothing_outside() {
    let mut piece = WorldPiece::zeroed();
    piece.state = Header::caused_by::<WorldState>(7);
    piece.count = 1;
    piece.objects[0].state.pose = ipc_types::Pose::IDENTITY;
    assert_eq!(piece.validate(), Ok(()));
    piece.objects[0].index = u32::try_from(MAX_OBJECTS).unwrap();
    assert_eq!(piece.validate().unwrap_err().field, "index");
    let mut state = WorldState::zeroed();
    piece.put(&mut state);
    assert_eq!(state.header.tick, 7);
    assert_eq!(state.objects, WorldState::zeroed().objects);
    piece.objects[0].index = 0;
    piece.count = u32::MAX;
    assert_eq!(piece.validate().unwrap_err().field, "count");
    assert_eq!(piece.objects().len(), PIECE_OBJECTS);
}
