//! The state as plain bytes, by names, so that a task continues after its file was edited.
//!
//! A flag per state and not a single state: parallel regions, and sub-behaviours that run,
//! have finished or are stopping, are part of the state. Hashes of full names survive added,
//! removed and reordered states.

use super::ids::StateId;
use super::runtime::Machine;
use super::set::{MAX_MEMBERS, SmallSet};

/// Layout of the bytes: version, count (two bytes each), then for each state
/// the hash of its full name (eight bytes) and a byte of flags. Little endian.
const VERSION: u16 = 1;
const HEADER: usize = 4;
const ENTRY: usize = 9;
// Bits of the flags. They are part of the format: a bit must not get another meaning.
const ACTIVE: u8 = 1;
const RUNNING: u8 = 2;
const FINISHED: u8 = 4;
const HALTING: u8 = 8;

/// Why saved bytes do not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RestoreError {
    /// They are too short, or too long.
    #[error("the checkpoint has {found} bytes, {expected} were expected; start from the beginning")]
    Length {
        /// Number of bytes.
        found: usize,
        /// Expected number of bytes.
        expected: usize,
    },
    /// They were written by another program.
    #[error(
        "the checkpoint has version {found}, this program reads {VERSION}; start from the beginning"
    )]
    Version {
        /// Its version.
        found: u16,
    },
    /// The active state is no longer in the definition.
    #[error("the state that was active is not in the file any more; start from the beginning")]
    Unknown,
}

/// FNV-1a of a name, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
pub(crate) fn name_hash(name: &str) -> u64 {
    // The constants are those of FNV-1a; another hash would not find the states of older
    // records.
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Splits a checkpoint into hashes and flags.
pub(crate) fn entries(bytes: &[u8]) -> Result<impl Iterator<Item = (u64, u8)>, RestoreError> {
    let word = |at: usize| Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    let short = RestoreError::Length {
        found: bytes.len(),
        expected: HEADER,
    };
    let (version, count) = word(0).zip(word(2)).ok_or(short)?;
    if version != VERSION {
        return Err(RestoreError::Version { found: version });
    }
    // The count must match the length exactly: a cut record would restore a part of the state.
    let expected = HEADER + ENTRY * usize::from(count);
    if bytes.len() != expected {
        return Err(RestoreError::Length {
            found: bytes.len(),
            expected,
        });
    }
    let body = bytes.get(HEADER..).unwrap_or_default();
    Ok(body.chunks_exact(ENTRY).filter_map(|entry| {
        let (hash, flags) = entry.split_at_checked(8)?;
        Some((u64::from_le_bytes(hash.try_into().ok()?), *flags.first()?))
    }))
}

/// Appends a checkpoint of `states`. Allocates only if `out` is too small.
pub(crate) fn write(states: impl Iterator<Item = (u64, u8)> + Clone, out: &mut Vec<u8>) {
    let count = u16::try_from(states.clone().count()).unwrap_or(u16::MAX);
    out.extend_from_slice(&VERSION.to_le_bytes());
    out.extend_from_slice(&count.to_le_bytes());
    for (hash, flags) in states.take(usize::from(count)) {
        out.extend_from_slice(&hash.to_le_bytes());
        out.push(flags);
    }
}

impl Machine {
    /// Largest number of bytes that [`Machine::save`] appends, for any state.
    pub fn record_bytes(&self) -> usize {
        HEADER + ENTRY * self.table.states.len().min(MAX_MEMBERS)
    }

    /// Appends the whole state to `out`.
    pub fn save(&self, out: &mut Vec<u8>) {
        let sets = [
            (self.active, ACTIVE),
            (self.running, RUNNING),
            (self.finished, FINISHED),
            (self.halting, HALTING),
        ];
        let states = self.table.states.iter().filter_map(move |it| {
            let flags = sets
                .iter()
                .filter(|(set, _)| set.contains(it.rank))
                .fold(0, |flags, (_, flag)| flags | flag);
            // States without a flag are left out, so a record is short for a large machine,
            // too.
            (flags != 0).then_some((it.hash, flags))
        });
        write(states, out);
    }

    /// Restores a state that was saved, perhaps by a machine with an older version of the
    /// file: states are found by name, and where an inner state no longer exists, the
    /// initial one of its parent is used.
    ///
    /// # Errors
    /// When the bytes are not a checkpoint, or no active state is known any more.
    /// The machine is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let mut sets = [SmallSet::default(); 4];
        for (hash, flags) in entries(bytes)? {
            let found = self.table.states.iter().find(|it| it.hash == hash);
            // A state that was removed from the file loses its flags; `mended` finds a
            // replacement.
            let Some(state) = found else { continue };
            for (set, flag) in sets.iter_mut().zip([ACTIVE, RUNNING, FINISHED, HALTING]) {
                if flags & flag != 0 {
                    set.insert(state.rank);
                }
            }
        }
        // Nothing is assigned before this line: on an error the machine is unchanged.
        let [wanted, running, finished, halting] = sets;
        let active = self.mended(&wanted).ok_or(RestoreError::Unknown)?;
        let runs = self.table.during;
        self.active = active;
        // Only active states run, and only those that still have a sub-behaviour in the file.
        self.running = running.intersection(&active).intersection(&runs);
        self.finished = finished.intersection(&active).difference(&running);
        // Not limited to active states: these were left, and have to be stopped nevertheless.
        self.halting = halting.intersection(&runs);
        // Waiting triggers belong to the call that was interrupted, which did not complete.
        self.queue.clear();
        Ok(())
    }

    /// The valid configuration nearest to `wanted`.
    fn mended(&self, wanted: &SmallSet) -> Option<SmallSet> {
        let states = self.table.states.iter();
        let outermost = states.filter(|it| it.parent.is_none());
        // Exactly one outermost state; two could be saved by a file in which one was inside.
        let root = outermost.clone().position(|it| wanted.contains(it.rank))?;
        let root = outermost.map(|it| it.rank).nth(root)?;
        let mut active = SmallSet::default();
        active.insert(root);
        // Parents come before their children in the file.
        for (at, it) in self.table.states.iter().enumerate() {
            if active.contains(it.rank) && it.has_children {
                active = active.union(&self.inner(StateId::of(at), wanted));
            }
        }
        Some(active)
    }

    /// The direct children of an active state that are active.
    fn inner(&self, parent: StateId, wanted: &SmallSet) -> SmallSet {
        let children = || {
            let states = self.table.states.iter();
            states.filter(move |it| it.parent == Some(parent))
        };
        let Some(it) = self.table.get(parent) else {
            return SmallSet::default();
        };
        let ranks = children().map(|child| child.rank);
        // All regions of a parallel state are active, whatever was saved.
        if it.parallel {
            return ranks.collect();
        }
        let chosen = ranks.clone().find(|rank| wanted.contains(*rank));
        let initial = ranks.clone().find(|rank| it.entry.contains(*rank));
        chosen.or(initial).into_iter().collect()
    }
}
