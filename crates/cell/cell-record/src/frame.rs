//! One moment of a recording, combined from its messages.

use ipc_types::{ArmStatus, Decision, MAX_ARMS, Wire, WorldPiece, WorldState};

use crate::channel::Channel;
use crate::entry::Entry;

/// Largest number of pieces searched for one state.
// The objects of a state are complete every ten ticks, in 20 pieces at most; 4,096 pieces
// without one are a damaged recording.
const MAX_PIECES: usize = 4096;

/// The last messages at one moment.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The world; untouched objects as of at most ten ticks before.
    pub world: Box<WorldState>,
    /// Status of each arm that had published one.
    pub status: Vec<ArmStatus>,
    /// All zeros where the task had not decided yet.
    pub decision: Box<Decision>,
}

/// Collects entries from the newest to the oldest.
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

    /// Adds an entry; entries that cannot be read are ignored.
    pub(crate) fn take(&mut self, entry: &Entry) {
        if entry.time_ns > self.time_ns {
            return;
        }
        match entry.channel {
            // Back to the first piece that names all objects: older pieces add nothing.
            Channel::World if !self.whole && self.pieces.len() < MAX_PIECES => {
                if let Ok(piece) = entry.read::<WorldPiece>() {
                    self.whole = piece.all_objects == 1 && piece.piece == 0;
                    self.pieces.push(piece);
                }
            }
            Channel::Status(arm) => {
                let slot = self.status.get_mut(usize::from(arm));
                // The first one found is the newest, so later ones are ignored.
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

    /// Whether a message of `channel` may add a missing part.
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

    /// The moment found; `None` without a state.
    pub(crate) fn frame(self) -> Option<Frame> {
        let mut world = Box::new(WorldState::zeroed());
        self.pieces.last()?;
        // Oldest first: newer pieces overwrite the objects they name.
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
