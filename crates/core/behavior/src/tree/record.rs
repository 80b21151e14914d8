//! The whole state of a tree as plain bytes, by the ids of its nodes, so that
//! it survives an edit of the file.
//!
//! What can go wrong here, and the rule that prevents it:
//! - the file was edited between kill and restart: entries are found by the hash of the id,
//!   never by index, so a node that was moved keeps its state and a new one starts without;
//! - a node kept its id but has another type: the kind is part of the entry, and the entry is
//!   counted as lost;
//! - damaged bytes: the lengths of all entries are checked before the first change, and a
//!   value outside of its enum is read as that of a node that never ran;
//! - states that fit one by one but not together, such as a running sequence whose current
//!   child is gone: `mend` repairs them, since a tick relies on them.
//!
//! A new field of [`Op`] that is state belongs into [`Fields`], with a new `VERSION`. A
//! forgotten one shows as a restored tree that answers differently, which the tests compare
//! after a restore at every tick.

use std::time::Duration;

use super::engine::Tree;
use super::flat::{Code, Counts, Held, NONE, Op};
use super::leaf::Host;
use crate::board::bytes::{Reader, close, open, with_length};
use crate::board::{Carried, RecordError};
use crate::status::{NodeStatus, ResetReason, Status};

/// After the header: time of the last tick (a byte whether there was one, ns),
/// count of entries; for each a hash and, with its length in front, the fields
/// of [`Fields`] and the state of the leaf. Then the checkpoint of the board.
const MAGIC: [u8; 4] = *b"BTre";
// A change of the layout needs another number: entries have no field names.
const VERSION: u16 = 1;

impl<H: Host> Tree<H> {
    /// Appends the whole state as a checkpoint. Uses no heap once `record` has
    /// room.
    pub fn save(&self, record: &mut Vec<u8>) {
        let start = open(record, MAGIC, VERSION);
        record.push(u8::from(self.last.is_some()));
        record.extend_from_slice(&nanos(self.last.unwrap_or_default()).to_le_bytes());
        let entries = u32::try_from(self.hashes.len()).unwrap_or(u32::MAX);
        record.extend_from_slice(&entries.to_le_bytes());
        for (op, hash) in self.run.flat.ops.iter().zip(&self.hashes) {
            record.extend_from_slice(&hash.to_le_bytes());
            with_length(record, |record| self.save_op(op, record));
        }
        with_length(record, |record| self.local.save(record));
        close(record, start);
    }

    fn save_op(&self, op: &Op, record: &mut Vec<u8>) {
        let flat = &self.run.flat;
        let side = usize::from(op.side);
        let fields = Fields {
            tag: op.code.tag(),
            status: op.status as u8,
            deferred: letter(op.deferred),
            last: letter(op.last),
            held: op.held as u8,
            reason: op.reason as u8,
            open: u8::from(op.open),
            cursor: self.hashes.get(op.cursor as usize).copied().unwrap_or(0),
            counter: op.counter,
        };
        fields.write(record);
        match op.code {
            Code::Leaf | Code::EternalGuard => {
                if let Some(leaf) = flat.leaves.get(side) {
                    leaf.save(record);
                }
            }
            Code::Timeout | Code::Wait | Code::Delay => {
                let deadline = flat.timers.get(side).map_or(Duration::ZERO, |t| t.deadline);
                record.extend_from_slice(&nanos(deadline).to_le_bytes());
            }
            Code::Count => {
                let counts = flat.counts.get(side).copied().unwrap_or_default();
                for count in words(counts) {
                    record.extend_from_slice(&count.to_le_bytes());
                }
            }
            _ => {}
        }
    }

    /// Restores the state that [`Tree::save`] wrote, node by node. Nodes that are not
    /// in the checkpoint are as if they never ran.
    ///
    /// # Errors
    /// [`RecordError`], and no change, for bytes that are not such a checkpoint.
    pub fn restore(&mut self, record: &[u8]) -> Result<Carried, RecordError> {
        let mut reader = Reader::open(record, MAGIC, VERSION, "tree")?;
        let last = (reader.u8()?, reader.u64()?);
        let count = reader.u32()?;
        // A first pass over the lengths alone, on a copy of the reader: after it no error can
        // occur in the middle of the change.
        let mut checked = reader.clone();
        for _ in 0..count {
            checked.u64()?;
            checked.sized()?;
        }
        let board = checked.sized()?;
        checked.end()?;
        // The board checks its own bytes before it changes, and is the last that can refuse.
        let keys = self.local.restore(board)?;
        // Nodes that are new in the file must not keep the state of before.
        self.forget();
        self.run.events.clear();
        // The flag distinguishes "no tick yet" from a tick at time zero.
        self.last = (last.0 != 0).then(|| Duration::from_nanos(last.1));
        let mut carried = keys;
        for _ in 0..count {
            let hash = reader.u64()?;
            let entry = reader.sized()?;
            if self.take(hash, entry) {
                carried.nodes += 1;
            } else {
                carried.lost += 1;
            }
        }
        // After all entries, since a composite is repaired by the states of its children.
        self.mend();
        Ok(carried)
    }

    fn take(&mut self, hash: u64, entry: &[u8]) -> bool {
        let place = self
            .by_hash
            .binary_search_by_key(&hash, |(known, _)| *known);
        let Some((_, i)) = place.ok().and_then(|p| self.by_hash.get(p)).copied() else {
            return false;
        };
        let Some((fields, rest)) = Fields::read(entry) else {
            return false;
        };
        // Another kind under the same id: the bytes mean something else.
        let own = self.run.flat.ops.get(i).copied();
        let Some(op) = own.filter(|op| op.code.tag() == fields.tag) else {
            return false;
        };
        // Leaf, timer or counts first: if they do not fit, the operation is not changed either.
        if !self.take_side(op, rest) {
            return false;
        }
        // The current child is stored by its id as well: children may have moved.
        let cursor = self.child_called(i, op, fields.cursor);
        if let Some(op) = self.run.flat.ops.get_mut(i) {
            fields.give(op);
            op.cursor = cursor;
        }
        true
    }

    fn take_side(&mut self, op: Op, bytes: &[u8]) -> bool {
        let flat = &mut self.run.flat;
        let side = usize::from(op.side);
        match op.code {
            Code::Leaf | Code::EternalGuard => flat
                .leaves
                .get_mut(side)
                .is_some_and(|leaf| leaf.restore(bytes)),
            Code::Timeout | Code::Wait | Code::Delay => {
                let nanos = bytes.try_into().map(u64::from_le_bytes);
                match (flat.timers.get_mut(side), nanos) {
                    (Some(timer), Ok(nanos)) => {
                        timer.deadline = Duration::from_nanos(nanos);
                        true
                    }
                    _ => false,
                }
            }
            Code::Count => match (flat.counts.get_mut(side), counts(bytes)) {
                (Some(own), Some(counts)) => {
                    *own = counts;
                    true
                }
                _ => false,
            },
            _ => bytes.is_empty(),
        }
    }

    /// The child of the composite `i` with that hash.
    fn child_called(&self, i: usize, op: Op, hash: u64) -> u32 {
        // Decorators have one child, at a fixed place.
        if !op.code.is_composite() {
            return NONE;
        }
        self.children(i)
            .find(|c| self.hashes.get(*c) == Some(&hash))
            .and_then(|c| u32::try_from(c).ok())
            .unwrap_or(NONE)
    }

    fn children(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let ops = &self.run.flat.ops;
        let end = ops.get(i).map_or(0, |op| op.end as usize);
        let next = move |c: &usize| ops.get(*c).map(|op| op.end as usize);
        std::iter::successors(Some(i + 1), next).take_while(move |c| *c < end)
    }

    /// Repairs states that come from an edited tree or from damaged bytes: a
    /// running composite continues with a child that it has, and only leaves halt.
    fn mend(&mut self) {
        for i in 0..self.run.flat.ops.len() {
            let op = self.run.flat.ops[i];
            if op.status == NodeStatus::Halting {
                // The number of halting leaves is not stored; a wrong one would stop the tree
                // for ever.
                if op.code == Code::Leaf {
                    self.run.halting += 1;
                } else {
                    // Only leaves are asked to halt: another operation would never leave this
                    // status.
                    self.run.flat.ops[i].status = NodeStatus::Invalid;
                }
            }
            // The first tick after a restore reports changes from here, not from the start.
            self.run.flat.ops[i].shown = self.run.flat.ops[i].status;
            // Children that ran and are now behind the current one have to be stopped at a
            // restart.
            if matches!(op.code, Code::Sequence { .. }) {
                let beyond = |c: &usize| op.cursor == NONE || *c > op.cursor as usize;
                let valid = |c: usize| self.run.flat.ops[c].status != NodeStatus::Invalid;
                let late = self.children(i).filter(beyond).any(valid);
                self.run.flat.ops[i].open = late;
            }
            let goes_on = matches!(op.code, Code::Sequence { .. } | Code::Selector { .. });
            if goes_on && op.status == NodeStatus::Running && op.cursor == NONE {
                // The running child, else the first: without a cursor the sequence would start
                // a second run while the first one is under way.
                let runs = |c: &usize| self.run.is_running(*c);
                let child = self.children(i).find(runs).or(self.children(i).next());
                let child = child.and_then(|c| u32::try_from(c).ok());
                self.run.flat.ops[i].cursor = child.unwrap_or(NONE);
            }
        }
    }
}

/// The fields that every operation has in a checkpoint.
struct Fields {
    tag: u8,
    status: u8,
    deferred: u8,
    last: u8,
    held: u8,
    reason: u8,
    open: u8,
    /// Hash of the current child.
    cursor: u64,
    counter: u32,
}

impl Fields {
    fn write(&self, record: &mut Vec<u8>) {
        record.extend_from_slice(&[
            self.tag,
            self.status,
            self.deferred,
            self.last,
            self.held,
            self.reason,
            self.open,
        ]);
        record.extend_from_slice(&self.cursor.to_le_bytes());
        record.extend_from_slice(&self.counter.to_le_bytes());
    }

    fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let ([tag, status, deferred, last, held, reason, open], rest) =
            bytes.split_first_chunk::<7>()?;
        let (cursor, rest) = rest.split_first_chunk::<8>()?;
        let (counter, rest) = rest.split_first_chunk::<4>()?;
        let fields = Self {
            tag: *tag,
            status: *status,
            deferred: *deferred,
            last: *last,
            held: *held,
            reason: *reason,
            open: *open,
            cursor: u64::from_le_bytes(*cursor),
            counter: u32::from_le_bytes(*counter),
        };
        Some((fields, rest))
    }

    /// Unknown numbers are read as those of a node that never ran.
    fn give(&self, op: &mut Op) {
        op.status = match self.status {
            1 => NodeStatus::Running,
            2 => NodeStatus::Success,
            3 => NodeStatus::Failure,
            4 => NodeStatus::Halting,
            _ => NodeStatus::Invalid,
        };
        op.deferred = answer(self.deferred);
        op.last = answer(self.last);
        op.held = match self.held {
            1 => Held::No,
            2 => Held::Yes,
            _ => Held::Unknown,
        };
        op.reason = match self.reason {
            1 => ResetReason::Preempted,
            2 => ResetReason::Aborted,
            3 => ResetReason::ParentDone,
            4 => ResetReason::TimedOut,
            _ => ResetReason::Explicit,
        };
        op.open = self.open != 0;
        op.counter = self.counter;
    }
}

fn letter(answer: Option<Status>) -> u8 {
    answer.map_or(0, |status| NodeStatus::from(status) as u8)
}

fn answer(word: u8) -> Option<Status> {
    match word {
        1 => Some(Status::Running),
        2 => Some(Status::Success),
        3 => Some(Status::Failure),
        _ => None,
    }
}

fn nanos(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

fn words(counts: Counts) -> [u32; 5] {
    let Counts {
        ticks,
        running,
        successes,
        failures,
        interrupts,
    } = counts;
    [ticks, running, successes, failures, interrupts]
}

fn counts(bytes: &[u8]) -> Option<Counts> {
    let bytes: &[u8; 20] = bytes.try_into().ok()?;
    let (words, _) = bytes.as_chunks::<4>();
    let word = |i: usize| words.get(i).copied().map(u32::from_le_bytes);
    Some(Counts {
        ticks: word(0)?,
        running: word(1)?,
        successes: word(2)?,
        failures: word(3)?,
        interrupts: word(4)?,
    })
}
