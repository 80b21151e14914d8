//! The checkpoints of the task, each with the decision it led to, in files that
//! outlive the process: the newest two, for a successor of this process, and one for
//! every [`RESUME_TICKS`] of the last seconds, for a successor of physics.

use std::path::{Path, PathBuf};

use cell_rt::SlotFile;
use ipc_types::{Decision, RESUME_TICKS, Wire};
use serde::{Deserialize, Serialize};

use robocell_task::checkpoint::{self, MAX_BYTES};

/// Names of the files in the run directory.
const FILE: &str = "task.slots";
const HISTORY_FILE: &str = "task.history";
/// Entries of the history: physics goes back by a second, and a busy machine's by
/// somewhat more.
const HISTORY: usize = 24;

/// The file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}; check that the run directory belongs to you and has room", path = path.display())]
pub struct SlotsError {
    path: PathBuf,
    source: std::io::Error,
}

/// What was written for one tick.
pub struct Saved {
    /// The tick.
    pub tick: u64,
    /// The decision that was made, to be published again if no process received it.
    pub decision: Decision,
    /// The task's checkpoint.
    pub checkpoint: Vec<u8>,
}

/// The files of the task.
pub struct Slots {
    file: SlotFile,
    history: SlotFile,
    run: u64,
    seq: u64,
    history_seq: u64,
    buffer: Vec<u8>,
    /// Tick from which the entry in `buffer` is in the history; `None` before the
    /// first decision of a start of physics.
    next_label: Option<u64>,
}

#[derive(Serialize, Deserialize)]
struct Head {
    run: u64,
    physics_generation: u32,
    tick: u64,
    /// The state before which the entry was the newest (history only).
    label: u64,
}

impl Slots {
    /// Opens the file in `run_dir`, or begins it.
    ///
    /// # Errors
    ///
    /// When it cannot be mapped.
    pub fn open(run_dir: &Path, run: u64) -> Result<Self, SlotsError> {
        let capacity = HEAD_BYTES + size_of::<Decision>() + usize::try_from(MAX_BYTES).unwrap_or(0);
        let open = |name: &str, slots: usize| {
            let path = run_dir.join(name);
            let file = SlotFile::with_slots(&path, capacity, slots);
            if file.as_ref().is_ok_and(SlotFile::was_damaged) {
                let path = path.display();
                cell_worker::warn(format_args!(
                    "{path} is damaged: without its newest checkpoint the task decides \
                     from what it sees"
                ));
            }
            file.map_err(|source| SlotsError { path, source })
        };
        let (file, history) = (open(FILE, 2)?, open(HISTORY_FILE, HISTORY)?);
        let seq = |file: &SlotFile| file.newest().map_or(0, |(seq, _)| seq);
        Ok(Self {
            seq: seq(&file),
            history_seq: seq(&history),
            file,
            history,
            run,
            buffer: Vec::with_capacity(capacity),
            next_label: None,
        })
    }

    /// The newest entry of this run and this start of physics.
    pub fn newest(&self, physics_generation: u32) -> Option<Saved> {
        let (_, bytes) = self.file.newest()?;
        let (head, saved) = self.entry(&bytes)?;
        (head.physics_generation == physics_generation).then_some(saved)
    }

    /// The entry to resume from when physics went back to the state of `tick`: what
    /// the task remembered when that state arrived, or the newest before that. `None`
    /// for a fresh scene.
    pub fn at(&self, tick: u64) -> Option<Saved> {
        if tick == 0 {
            return None;
        }
        let newest = self.file.newest();
        let newest = newest.and_then(|(_, bytes)| self.entry(&bytes));
        if let Some((_, saved)) = newest.filter(|(head, _)| head.tick <= tick) {
            return Some(saved);
        }
        // Entries of a time that physics went back before are of no use.
        let mut earliest = u64::MAX;
        for (_, bytes) in self.history.all() {
            let Some((head, saved)) = self.entry(&bytes) else {
                continue;
            };
            if head.label < earliest {
                if head.label <= tick {
                    return Some(saved);
                }
                earliest = head.label;
            }
        }
        None
    }

    fn entry(&self, bytes: &[u8]) -> Option<(Head, Saved)> {
        let (head, rest) = bytes.split_at_checked(HEAD_BYTES)?;
        let head: Head = checkpoint::from_bytes(head).ok()?;
        if head.run != self.run {
            return None;
        }
        let (decision, checkpoint) = rest.split_at_checked(size_of::<Decision>())?;
        let saved = Saved {
            tick: head.tick,
            decision: Decision::from_bytes(decision)?,
            checkpoint: checkpoint.to_vec(),
        };
        Some((head, saved))
    }

    /// The next decision is on the state of `tick`: the entry written last is what
    /// was remembered when it arrived.
    pub fn deciding_on(&mut self, physics_generation: u32, tick: u64) {
        let label = tick - tick % RESUME_TICKS;
        let is_due = self.next_label.is_some_and(|next| label >= next);
        self.next_label = Some(label + RESUME_TICKS);
        let written = self.newest_head();
        if let Some(mut head) = written.filter(|head| {
            is_due && head.physics_generation == physics_generation && head.tick < label
        }) {
            head.label = label;
            let head = checkpoint::to_bytes(&head);
            self.buffer.splice(..HEAD_BYTES, head);
            self.history_seq += 1;
            self.history.write(self.history_seq, &self.buffer);
        }
    }

    /// Of the entry written last by this process.
    fn newest_head(&self) -> Option<Head> {
        checkpoint::from_bytes(self.buffer.get(..HEAD_BYTES)?).ok()
    }

    /// Writes an entry; `false` when it is too long.
    pub fn write(
        &mut self,
        physics_generation: u32,
        tick: u64,
        decision: &Decision,
        checkpoint: &[u8],
    ) -> bool {
        self.seq += 1;
        self.buffer.clear();
        let head = Head {
            run: self.run,
            physics_generation,
            tick,
            label: 0,
        };
        self.buffer.extend(checkpoint::to_bytes(&head));
        self.buffer.extend(decision.as_bytes());
        self.buffer.extend(checkpoint);
        self.file.write(self.seq, &self.buffer)
    }
}

/// Bytes of a [`Head`] with fixed-size numbers.
const HEAD_BYTES: usize = 8 + 4 + 8 + 8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_run_and_another_physics_are_not_remembered() {
        let dir = std::env::temp_dir().join(format!("robocell-slots-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let mut slots = Slots::open(&dir, 7).unwrap();
        assert!(slots.newest(1).is_none());
        let mut decision = Decision::zeroed();
        decision.drops = 3;
        for tick in [10, 20] {
            assert!(slots.write(1, tick, &decision, b"checkpoint"));
        }
        drop(slots);
        let slots = Slots::open(&dir, 7).unwrap();
        let saved = slots.newest(1).unwrap();
        assert_eq!(
            (saved.tick, saved.decision.drops, &saved.checkpoint[..]),
            (20, 3, &b"checkpoint"[..])
        );
        assert!(slots.newest(2).is_none());
        assert!(Slots::open(&dir, 8).unwrap().newest(1).is_none());
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn what_was_remembered_when_a_state_arrived_is_found_again_on_the_present_timeline() {
        let dir = std::env::temp_dir().join(format!("robocell-history-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let mut slots = Slots::open(&dir, 7).unwrap();
        let decide = |slots: &mut Slots, generation: u32, ticks: std::ops::Range<u64>| {
            for tick in ticks.step_by(10) {
                slots.deciding_on(generation, tick);
                let said = format!("{generation}: {tick}");
                slots.write(generation, tick, &Decision::zeroed(), said.as_bytes());
            }
        };
        let found = |slots: &Slots, tick| {
            let saved = slots.at(tick)?;
            Some(String::from_utf8(saved.checkpoint).unwrap())
        };
        assert_eq!(found(&slots, 0), None);
        decide(&mut slots, 1, 0..1_500);
        assert_eq!(found(&slots, 1_000).as_deref(), Some("1: 990"));
        assert_eq!(
            found(&slots, 1_490).as_deref(),
            Some("1: 1490"),
            "nothing was lost"
        );
        // Physics goes back to 900 and gets to 1150.
        decide(&mut slots, 2, 900..1_150);
        assert_eq!(found(&slots, 1_100).as_deref(), Some("2: 1090"));
        assert_eq!(found(&slots, 1_000).as_deref(), Some("2: 990"));
        assert_eq!(found(&slots, 900).as_deref(), Some("1: 890"));
        // As another process sees it.
        let slots = Slots::open(&dir, 7).unwrap();
        assert_eq!(found(&slots, 1_000).as_deref(), Some("2: 990"));
        assert_eq!(found(&Slots::open(&dir, 8).unwrap(), 1_000), None);
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
