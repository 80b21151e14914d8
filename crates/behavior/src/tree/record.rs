//! The whole state of a tree as plain bytes, by the ids of its nodes, so that
//! it survives an edited file.

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

    /// Takes the state of [`Tree::save`] back, node by node. Nodes that are not
    /// in the checkpoint are as if they never ran.
    ///
    /// # Errors
    /// [`RecordError`], and no change, for bytes that are not such a checkpoint.
    pub fn restore(&mut self, record: &[u8]) -> Result<Carried, RecordError> {
        let mut reader = Reader::open(record, MAGIC, VERSION, "tree")?;
        let last = (reader.u8()?, reader.u64()?);
        let count = reader.u32()?;
        let mut checked = reader.clone();
        for _ in 0..count {
            checked.u64()?;
            checked.sized()?;
        }
        let board = checked.sized()?;
        checked.end()?;
        let keys = self.local.restore(board)?;
        self.forget();
        self.run.events.clear();
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
        let own = self.run.flat.ops.get(i).copied();
        let Some(op) = own.filter(|op| op.code.tag() == fields.tag) else {
            return false;
        };
        if !self.take_side(op, rest) {
            return false;
        }
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

    /// Makes sense of states that came from an edited tree, or from nowhere: a
    /// composite that runs continues with a child it has, and only leaves halt.
    fn mend(&mut self) {
        for i in 0..self.run.flat.ops.len() {
            let op = self.run.flat.ops[i];
            if op.status == NodeStatus::Halting {
                if op.code == Code::Leaf {
                    self.run.halting += 1;
                } else {
                    self.run.flat.ops[i].status = NodeStatus::Invalid;
                }
            }
            self.run.flat.ops[i].shown = self.run.flat.ops[i].status;
            if matches!(op.code, Code::Sequence { .. }) {
                let beyond = |c: &usize| op.cursor == NONE || *c > op.cursor as usize;
                let valid = |c: usize| self.run.flat.ops[c].status != NodeStatus::Invalid;
                let late = self.children(i).filter(beyond).any(valid);
                self.run.flat.ops[i].open = late;
            }
            let goes_on = matches!(op.code, Code::Sequence { .. } | Code::Selector { .. });
            if goes_on && op.status == NodeStatus::Running && op.cursor == NONE {
                let runs = |c: &usize| self.run.is_running(*c);
                let child = self.children(i).find(runs).or(self.children(i).next());
                let child = child.and_then(|c| u32::try_from(c).ok());
                self.run.flat.ops[i].cursor = child.unwrap_or(NONE);
            }
        }
    }
}

/// What every operation has in a checkpoint.
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

    /// Unknown words mean what they mean in a node that never ran.
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
