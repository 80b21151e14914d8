//! Copies for the recorder: every message as it was sent, in deep buffers of their own, so that
//! the control topics stay shallow (ADR 0012).

use crate::header::Header;
use crate::validate::{Check, Invalid, Validate};
use crate::wire::wire;
use crate::world::{OBJECT_DRAGGED, OBJECT_OBSTACLE, OBJECT_TOUCHED};
use crate::{
    ArmState, EquipmentState, MAX_ARMS, MAX_OBJECTS, ObjectState, OperatorPanel, WorldState,
};

/// Objects one [`WorldPiece`] has room for.
// A state of 20 kB at 1 kHz with a second of buffer is more shared memory than many machines
// give; a piece is a fifth of a state (ADR 0012).
pub const PIECE_OBJECTS: usize = 8;
/// Ticks between two states whose objects are all recorded; those between name only touched or
/// pulled objects, and obstacles that changed, as controllers use these in every tick.
// A replay of the task needs all objects where it decides, and nowhere else.
pub const OBJECT_TICKS: u64 = crate::DECISION_TICKS;
/// Bytes of a checkpoint in one [`Keyframe`]; a longer one takes several.
// A task's checkpoint is about 1 kB for 27 nodes (ADR 0008): nearly all fit one message.
pub const KEYFRAME_BYTES: usize = 16 * 1024;

wire! {
    /// One object of a [`WorldPiece`].
    pub struct PieceObject {
        /// Index in [`WorldState::objects`].
        pub index: u32,
        /// Zero.
        pub reserved: u32,
        /// As in the state.
        pub state: ObjectState,
    }
}

wire! {
    /// A [`WorldState`] for the recorder, all of it but for the objects that
    /// are not due in this tick. States with more objects take several pieces, each
    /// with all the rest.
    pub struct WorldPiece {
        /// Header of the piece.
        pub header: Header,
        /// Header of the state.
        pub state: Header,
        /// From 0 up.
        pub piece: u32,
        /// Pieces of this state.
        pub pieces: u32,
        /// As in the state.
        pub flags: u32,
        /// As in the state.
        pub arm_count: u32,
        /// As in the state: of the cell, not of this piece.
        pub object_count: u32,
        /// As in the state.
        pub script_line: u32,
        /// As in the state.
        pub script_left: u32,
        /// As in the state.
        pub quarantined: u32,
        /// As in the state.
        pub overruns: u64,
        /// As in the state.
        pub resumed_tick: u64,
        /// As in the state.
        pub saving_tick: u64,
        /// As in the state.
        pub saved_tick: u64,
        /// As in the state.
        pub state_hash: u64,
        /// As in the state.
        pub panel: OperatorPanel,
        /// As in the state.
        pub equipment: EquipmentState,
        /// As in the state.
        pub arms: [ArmState; MAX_ARMS],
        /// 1 when the pieces of this state name all objects.
        pub all_objects: u32,
        /// Valid entries of `objects`.
        pub count: u32,
        /// Some of the objects.
        pub objects: [PieceObject; PIECE_OBJECTS],
    }
}

wire! {
    /// A checkpoint of a process, or a part of it, as of the message with number `after_seq` on
    /// its main topic (a command, a decision): a process that restores the bytes of all parts
    /// and gets the later inputs computes the same as the original process.
    pub struct Keyframe {
        /// Header; `tick` is the tick of that message.
        pub header: Header,
        /// Number of the last message the checkpoint covers, 0 before the first.
        pub after_seq: u64,
        /// Bytes of the checkpoint, all parts together.
        pub total: u64,
        /// Place of `bytes` in the checkpoint.
        pub offset: u64,
        /// Valid entries of `bytes`.
        pub len: u32,
        /// Zero.
        pub reserved: u32,
        /// The part; the format of the checkpoint contains its version.
        pub bytes: [u8; KEYFRAME_BYTES],
    }
}

impl WorldPiece {
    /// Copies everything that is the same in all pieces of `state`.
    pub fn take(&mut self, state: &WorldState) {
        // Field by field: a new field of a state that is
        // forgotten here would be missing in replays.
        self.state = state.header;
        self.flags = state.flags;
        self.arm_count = state.arm_count;
        self.object_count = state.object_count;
        self.script_line = state.script_line;
        self.script_left = state.script_left;
        self.quarantined = state.quarantined;
        self.overruns = state.overruns;
        self.resumed_tick = state.resumed_tick;
        self.saving_tick = state.saving_tick;
        self.saved_tick = state.saved_tick;
        self.state_hash = state.state_hash;
        self.panel = state.panel;
        self.equipment = state.equipment;
        self.arms = state.arms;
    }

    /// Writes the content of the piece into `state`; objects it does not name stay.
    pub fn put(&self, state: &mut WorldState) {
        state.header = self.state;
        state.flags = self.flags;
        state.arm_count = self.arm_count;
        state.object_count = self.object_count;
        state.script_line = self.script_line;
        state.script_left = self.script_left;
        state.quarantined = self.quarantined;
        state.overruns = self.overruns;
        state.resumed_tick = self.resumed_tick;
        state.saving_tick = self.saving_tick;
        state.saved_tick = self.saved_tick;
        state.state_hash = self.state_hash;
        state.panel = self.panel;
        state.equipment = self.equipment;
        state.arms = self.arms;
        // The index was validated; `get_mut` keeps a damaged recording from ending the reader.
        for object in self.objects() {
            if let Some(place) = state.objects.get_mut(object.index as usize) {
                *place = object.state;
            }
        }
    }

    /// The objects named.
    pub fn objects(&self) -> &[PieceObject] {
        // Bounded here as well: a piece from a recording may be read before it is validated.
        &self.objects[..(self.count as usize).min(PIECE_OBJECTS)]
    }
}

impl Keyframe {
    /// The part.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..(self.len as usize).min(KEYFRAME_BYTES)]
    }

    /// Copies as much of `checkpoint` from `offset` on as fits.
    pub fn set(&mut self, checkpoint: &[u8], offset: usize) {
        // An offset at the end gives an empty part: an empty checkpoint is sent as well.
        let part = checkpoint.get(offset..).unwrap_or_default();
        let part = part.get(..KEYFRAME_BYTES).unwrap_or(part);
        self.bytes[..part.len()].copy_from_slice(part);
        self.total = checkpoint.len() as u64;
        self.offset = offset as u64;
        self.len = number(part.len());
    }

    /// Whether no part of the checkpoint follows this one.
    pub fn is_last(&self) -> bool {
        self.offset.saturating_add(u64::from(self.len)) >= self.total
    }
}

impl Validate for WorldPiece {
    fn validate(&self) -> Result<(), Invalid> {
        Check::count("arm_count", self.arm_count, MAX_ARMS)?;
        Check::count("object_count", self.object_count, MAX_OBJECTS)?;
        Check::count("count", self.count, PIECE_OBJECTS)?;
        for object in self.objects() {
            // Against the array: `put` copies into it by this index.
            Check::count("index", object.index, MAX_OBJECTS - 1)?;
            object.state.pose.check()?;
            object.state.twist.check()?;
        }
        for arm in &self.arms[..self.arm_count as usize] {
            arm.validate()?;
        }
        self.panel.check()?;
        self.equipment.validate()
    }
}

impl Validate for Keyframe {
    fn validate(&self) -> Result<(), Invalid> {
        Check::count("len", self.len, KEYFRAME_BYTES)?;
        let end = self.offset.saturating_add(u64::from(self.len));
        if end <= self.total {
            return Ok(());
        }
        Err(Invalid {
            field: "offset",
            index: 0,
            value: self.offset as f64,
            allowed: "a part inside of the checkpoint",
        })
    }
}

/// A state divided into pieces; [`WorldPiece::take`] has the shared part.
pub struct Pieces<'a> {
    next: u32,
    count: u32,
    all: bool,
    first_object: usize,
    before: &'a [ObjectState],
}

impl<'a> Pieces<'a> {
    /// The pieces that `state` has to be sent in. `before` are the objects of the state sent
    /// before it, empty for the first.
    pub fn of(state: &WorldState, before: &'a [ObjectState]) -> Self {
        // From the tick, so that it does not depend on when physics or the recorder started.
        let all = state.header.tick.is_multiple_of(OBJECT_TICKS);
        Self::with(state, all, before)
    }

    /// Pieces with all objects of `state`, at any tick.
    pub fn whole(state: &WorldState) -> Self {
        Self::with(state, true, &[])
    }

    fn with(state: &WorldState, all: bool, before: &'a [ObjectState]) -> Self {
        let mut pieces = Self {
            next: 0,
            count: 0,
            all,
            first_object: 0,
            before,
        };
        let named = (0..state.objects().len()).filter(|index| pieces.names(state, *index));
        // At least one: the arms are recorded in every tick, also of a cell without objects.
        pieces.count = number(named.count().div_ceil(PIECE_OBJECTS)).max(1);
        pieces
    }

    fn names(&self, state: &WorldState, index: usize) -> bool {
        let object = &state.objects[index];
        // Others are recorded in every tenth tick: all in every tick would be 20 kB at 1 kHz.
        let has = |flags: u32| object.flags & flags != 0;
        let changed = || self.before.get(index) != Some(object);
        self.all || has(OBJECT_TOUCHED | OBJECT_DRAGGED) || (has(OBJECT_OBSTACLE) && changed())
    }

    /// Whether a piece is left.
    pub fn has_more(&self) -> bool {
        self.next < self.count
    }

    /// Writes the next piece of the same `state`; false when there is none left.
    pub fn write_next(&mut self, state: &WorldState, out: &mut WorldPiece) -> bool {
        if !self.has_more() {
            return false;
        }
        out.header = Header::caused_by::<WorldPiece>(state.header.tick);
        out.take(state);
        (out.piece, out.pieces) = (self.next, self.count);
        out.all_objects = u32::from(self.all);
        out.count = 0;
        // The search continues where the last piece ended, so all pieces cost one pass.
        while self.first_object < state.objects().len() && (out.count as usize) < PIECE_OBJECTS {
            let index = self.first_object;
            if self.names(state, index) {
                out.objects[out.count as usize] = PieceObject {
                    index: number(index),
                    reserved: 0,
                    state: state.objects[index],
                };
                out.count += 1;
            }
            self.first_object += 1;
        }
        self.next += 1;
        true
    }
}

fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Wire as _;

    fn state(tick: u64) -> WorldState {
        let mut state = WorldState::zeroed();
        state.header = Header::caused_by::<WorldState>(tick);
        state.object_count = 20;
        for (index, object) in state.objects.iter_mut().take(20).enumerate() {
            object.pose.position[0] = index as f64;
        }
        state.objects[3].flags = OBJECT_TOUCHED;
        state.panel.task_start = 7;
        state
    }

    fn put_together(sent: &WorldState) -> (WorldState, u32) {
        let before = state(sent.header.tick - 1).objects;
        let (mut pieces, mut piece) = (Pieces::of(sent, &before), WorldPiece::zeroed());
        let (mut out, mut count) = (WorldState::zeroed(), 0);
        while pieces.write_next(sent, &mut piece) {
            assert_eq!((piece.piece, piece.pieces), (count, piece.pieces));
            piece.put(&mut out);
            count += 1;
        }
        (out, count)
    }

    #[test]
    fn every_tenth_state_is_whole_and_the_others_name_what_is_touched() {
        let sent = state(10);
        assert_eq!(put_together(&sent), (sent, 3));
        let sent = state(11);
        let (heard, pieces) = put_together(&sent);
        assert_eq!((heard.panel, pieces), (sent.panel, 1));
        assert_eq!(heard.objects[3], sent.objects[3]);
        assert_eq!(heard.objects[4].pose.position[0], 0.0);
    }

    #[test]
    fn an_obstacle_is_named_when_it_changed() {
        let mut sent = state(11);
        sent.objects[5].flags = OBJECT_OBSTACLE;
        let before = sent.objects;
        let mut piece = WorldPiece::zeroed();
        assert!(Pieces::of(&sent, &before).write_next(&sent, &mut piece));
        assert_eq!(piece.objects().len(), 1);
        sent.objects[5].pose.position[2] = 0.1;
        assert!(Pieces::of(&sent, &before).write_next(&sent, &mut piece));
        assert_eq!(piece.objects().len(), 2);
    }

    #[test]
    fn a_long_checkpoint_comes_in_parts_one_after_the_other() {
        let checkpoint: Vec<u8> = (0..KEYFRAME_BYTES * 2 + 3)
            .map(|i| u8::try_from(i % 251).unwrap())
            .collect();
        let (mut whole, mut frame) = (Vec::<u8>::new(), Keyframe::zeroed());
        loop {
            frame.set(&checkpoint, whole.len());
            assert_eq!(frame.offset, whole.len() as u64);
            whole.extend(frame.bytes());
            if frame.is_last() {
                break;
            }
        }
        assert_eq!(whole, checkpoint);
        frame.set(&[], 0);
        assert!(frame.is_last() && frame.bytes().is_empty() && frame.validate().is_ok());
        frame.offset = 1;
        assert_eq!(frame.validate().unwrap_err().field, "offset");
    }
}
