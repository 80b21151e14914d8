//! One moment of a recording, put together.

use ipc_types::{ArmStatus, Decision, MAX_ARMS, Wire, WorldPiece, WorldState};

use crate::channel::Channel;
use crate::entry::Entry;

/// A state is whole after this many pieces, or never.
const MAX_PIECES: usize = 4096;

/// What was said last at one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The world; objects that nothing touched as of at most ten ticks before.
    pub world: Box<WorldState>,
    /// Of each arm that had said something.
    pub status: Vec<ArmStatus>,
    /// All zeros where the task had not decided yet.
    pub decision: Box<Decision>,
}

/// Looks at entries from the newest to the oldest.
#[derive(Default)]
pub(crate) struct Backwards {
    time_ns: u64,
    pieces: Vec<WorldPiece>,
    whole: bool,
    status: [Option<ArmStatus>; MAX_ARMS],
    decision: Option<Box<Decision>>,
}

impl Backwards {
    pub(crate) fn at(time_ns: u64) -> Self {
        Self {
            time_ns,
            ..Self::default()
        }
    }

    /// Takes an entry in; those that cannot be read say nothing.
    pub(crate) fn take(&mut self, entry: &Entry) {
        if entry.time_ns > self.time_ns {
            return;
        }
        match entry.channel {
            Channel::World if !self.whole && self.pieces.len() < MAX_PIECES => {
                if let Ok(piece) = entry.read::<WorldPiece>() {
                    self.whole = piece.all_objects == 1 && piece.piece == 0;
                    self.pieces.push(piece);
                }
            }
            Channel::Status(arm) => {
                let slot = self.status.get_mut(usize::from(arm));
                if let Some(slot @ None) = slot {
                    *slot = entry.read().ok();
                }
            }
            Channel::Decision if self.decision.is_none() => {
                self.decision = entry.read().ok().map(Box::new);
            }
            _ => {}
        }
    }

    /// Whether a message of `channel` may add what is missing.
    pub(crate) fn lacks(&self, channel: Channel, arms: usize) -> bool {
        match channel {
            Channel::World => !self.whole,
            Channel::Decision => self.decision.is_none(),
            Channel::Status(arm) => {
                let arm = usize::from(arm);
                arm < arms && self.status.get(arm).is_some_and(Option::is_none)
            }
            _ => false,
        }
    }

    pub(crate) fn has_world(&self) -> bool {
        self.whole
    }

    pub(crate) fn is_complete(&self, arms: usize) -> bool {
        let status = self.status.iter().take(arms).all(Option::is_some);
        self.whole && status && self.decision.is_some()
    }

    /// What was found; `None` without a state.
    pub(crate) fn frame(self) -> Option<Frame> {
        let mut world = Box::new(WorldState::zeroed());
        self.pieces.last()?;
        for piece in self.pieces.iter().rev() {
            piece.put(&mut world);
        }
        Some(Frame {
            world,
            status: self.status.into_iter().flatten().collect(),
            decision: self
                .decision
                .unwrap_or_else(|| Box::new(Decision::zeroed())),
        })
    }
}
