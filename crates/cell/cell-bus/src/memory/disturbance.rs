//! What can happen to a message between its writer and its readers.

use ipc_types::header::Message;

/// Of one message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// A bit of it is flipped, so that a reader can tell: the message is of another run or type,
    /// or a value in it makes no sense. `draw` chooses the bit.
    // Any other flipped bit is a valid message. No checksum is on the bus: its memory is trusted.
    Damage {
        /// Chooses the bit.
        draw: u64,
    },
    /// It comes again after so many newer ones, or as soon as a reader has taken it; so do those
    /// that follow.
    Again {
        /// Newer ones.
        after: u32,
        /// Messages of which each comes again.
        count: u32,
    },
    /// It comes after so many newer ones only.
    Late {
        /// Newer ones.
        after: u32,
    },
}

impl Disturbance {
    /// What happens to the message after that to which this happens.
    pub(super) fn next(self) -> Option<Self> {
        match self {
            Self::Again { after, count } if count > 1 => {
                let count = count - 1;
                Some(Self::Again { after, count })
            }
            _ => None,
        }
    }
}

/// `message` with a flipped bit that its readers can tell, the first from the one that `draw`
/// chooses on.
pub(super) fn damaged<T: Message>(message: &T, draw: u64) -> Option<T> {
    let mut bytes = message.as_bytes().to_vec();
    let bits = 8 * bytes.len();
    let first = usize::try_from(draw % bits as u64).ok()?;
    // A stride that has no factor in common with a power of two reaches every bit of a word.
    (0..bits).find_map(|step| {
        let bit = (first + 67 * step) % bits;
        bytes[bit / 8] ^= 1 << (bit % 8);
        let flipped = T::from_bytes(&bytes)?;
        bytes[bit / 8] ^= 1 << (bit % 8);
        let (old, new) = (message.header(), flipped.header());
        let is_other = (old.run, old.schema) != (new.run, new.schema);
        (is_other || flipped.validate().is_err()).then_some(flipped)
    })
}
