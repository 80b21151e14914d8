//! The checkpoints of the task, each with the decision made from it, in files that
//! outlive the process: the newest two, for a successor of this process, and those for
//! the states that physics saved, for a successor of physics.
//!
//! What can go wrong here, and the rule that prevents it:
//! - a kill during a write: each file has several slots, a write goes into one that is not
//!   needed, and its number and checksum are valid only when it is complete. 300 kills of a
//!   process that rewrote a slot without pause, 278 of them within a write, left none torn;
//! - physics resumes from an older state and the task from a newer checkpoint: entries of the
//!   history are labelled with the state they belong to, and the one for the state that
//!   physics would resume from is never replaced;
//! - physics resumed earlier in the run: entries of the abandoned timeline have the same
//!   ticks and must not be found (`on_this_timeline` in `history.rs`);
//! - files of another run in the same directory: every entry carries the number of its run;
//! - a checkpoint that is too long, or a full disk: the cell continues, but the user is warned
//!   before the kill that would lose it (`lost`).
//!
//! A change must write an entry before its decision is published, and must not wait for a
//! disk: the file is mapped memory, and the decision has 10 ms.

mod history;

use std::io;
use std::path::{Path, PathBuf};

use cell_rt::{MemoryFile, SlotFile};
use ipc_types::{Decision, Wire};
use serde::{Deserialize, Serialize};

use robocell_task::checkpoint::{self, MAX_BYTES};

/// Names of the files in the run directory.
const FILE: &str = "task.slots";
const HISTORY_FILE: &str = "task.history";
/// Entries of the history: for the state that physics saved last, for one that is
/// being written, and two before, in case a process is killed between these.
const HISTORY: usize = 4;
/// Initial room for a checkpoint; a longer one enlarges the file (bytes).
// A tree of 27 nodes has a record of about 1 kB (ADR 0008); policies in Python pickle more.
const FIRST_ROOM: usize = 64 * 1024;
/// Bytes of a [`Head`] with fixed-size numbers: run, generation, tick and label.
const HEAD_BYTES: usize = 8 + 4 + 8 + 8;

/// The file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}; check that the run directory belongs to you and has room", path = path.display())]
pub struct SlotsError {
    path: PathBuf,
    source: std::io::Error,
}

/// The entry that was written for one tick.
pub struct Saved {
    /// The tick.
    pub tick: u64,
    /// The decision that was made, to be published again if it reached no process.
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
    /// The entry written last.
    buffer: Vec<u8>,
    /// By slot of the history: the state to which its entry belongs, and its number.
    labels: [Option<(u64, u64)>; HISTORY],
    /// Why the newest entry, and that of the history, could not be written; empty
    /// if they were.
    problem: String,
    history_problem: String,
    /// The files that were damaged at the start.
    damage: String,
}

/// The files of a modelled task.
#[derive(Clone, Debug, Default)]
pub struct ModelFiles {
    /// In place of `task.slots`.
    pub newest: MemoryFile,
    /// In place of `task.history`.
    pub history: MemoryFile,
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
    /// Opens the files in `run_dir`, or creates them.
    ///
    /// # Errors
    ///
    /// When they cannot be mapped.
    pub fn open(run_dir: &Path, run: u64) -> Result<Self, SlotsError> {
        Self::of(run, |name, capacity, slots| {
            let path = run_dir.join(name);
            let file = SlotFile::with_slots(&path, capacity, slots);
            (path, file)
        })
    }

    /// As [`Slots::open`], of a modelled task.
    ///
    /// # Errors
    ///
    /// None that a model has.
    pub fn model(files: &ModelFiles, run: u64) -> Result<Self, SlotsError> {
        Self::of(run, |name, capacity, slots| {
            let file = if name == FILE {
                &files.newest
            } else {
                &files.history
            };
            (name.into(), SlotFile::in_memory(file, capacity, slots))
        })
    }

    /// `open` opens the file of a name, with room for a number of records of a length.
    fn of(
        run: u64,
        open: impl Fn(&str, usize, usize) -> (PathBuf, io::Result<SlotFile>),
    ) -> Result<Self, SlotsError> {
        let capacity = HEAD_BYTES + size_of::<Decision>() + FIRST_ROOM;
        let mut damage = String::new();
        let mut open = |name: &str, slots: usize| {
            // A damaged file is reported and created again: a task without a checkpoint can
            // run, one without a file could not resume from anything.
            let (path, file) = open(name, capacity, slots);
            if file.as_ref().is_ok_and(SlotFile::was_damaged) {
                let path = path.display();
                damage = format!("checkpoints in {path}, which is damaged");
                cell_worker::warn(format_args!("lost: {damage}"));
            }
            file.map_err(|source| SlotsError { path, source })
        };
        let (file, history) = (open(FILE, 2)?, open(HISTORY_FILE, HISTORY)?);
        // Numbers continue: an entry with number 1 would be older than the slots of the
        // predecessor.
        let seq = |file: &SlotFile| file.newest().map_or(0, |(seq, _)| seq);
        let mut this = Self {
            seq: seq(&file),
            history_seq: seq(&history),
            file,
            history,
            run,
            buffer: Vec::with_capacity(capacity),
            labels: [None; HISTORY],
            problem: String::new(),
            history_problem: String::new(),
            damage,
        };
        for (slot, seq, bytes) in this.history.all_slots() {
            // An entry of another run has no label, so its slot is the first to be replaced.
            let head = this.entry(&bytes).map(|(head, _)| (head.label, seq));
            if let Some(place) = this.labels.get_mut(slot) {
                *place = head;
            }
        }
        Ok(this)
    }

    /// Checkpoints that are lost, or would be lost with this process; empty for none.
    pub fn lost(&self) -> &str {
        let all = [&self.problem, &self.history_problem, &self.damage];
        all.into_iter()
            .find(|text| !text.is_empty())
            .map_or("", String::as_str)
    }

    /// Reports that the task before this one left no checkpoint, if there is none.
    pub fn miss_checkpoint(&mut self) {
        // A damaged file is the reason already, and a checkpoint means that there was one.
        if self.damage.is_empty() && self.file.newest().is_none() {
            "the checkpoint of the task before; this task decides from its observations"
                .clone_into(&mut self.damage);
            cell_worker::warn(format_args!("lost: {}", self.damage));
        }
    }

    /// The newest entry of this run and this start of physics.
    pub fn newest(&self, physics_generation: u32) -> Option<Saved> {
        let (_, bytes) = self.file.newest()?;
        let (head, saved) = self.entry(&bytes)?;
        // After a restart of physics the newest entry may be of a future that did not happen;
        // the history decides then.
        (head.physics_generation == physics_generation).then_some(saved)
    }

    fn entry(&self, bytes: &[u8]) -> Option<(Head, Saved)> {
        let (head, rest) = bytes.split_at_checked(HEAD_BYTES)?;
        let head: Head = checkpoint::from_bytes(head).ok()?;
        // The run directory may be used again; the ticks of an earlier run mean nothing here.
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

    /// Writes an entry; one that cannot be kept is reported by [`Slots::lost`].
    pub fn write(
        &mut self,
        physics_generation: u32,
        tick: u64,
        decision: &Decision,
        checkpoint: &[u8],
    ) {
        // The buffer is kept: `keep` may put the same bytes into the history without encoding
        // twice.
        self.seq += 1;
        self.buffer.clear();
        let head = Head {
            run: self.run,
            physics_generation,
            tick,
            label: 0,
        };
        // The label is set in `keep`; its bytes are there already, so that it can be replaced.
        self.buffer.extend(checkpoint::to_bytes(&head));
        self.buffer.extend(decision.as_bytes());
        self.buffer.extend(checkpoint);
        let written = if checkpoint.len() > MAX_BYTES {
            // Cleared, so that `keep` does not label an older entry as this one.
            self.buffer.clear();
            let bytes = checkpoint.len();
            Err(format!(
                "at most {MAX_BYTES} bytes are kept, it has {bytes}"
            ))
        } else {
            self.file
                .write(self.seq, &self.buffer)
                .map_err(|e| e.to_string())
        };
        note(&mut self.problem, "a killed task", written);
    }
}

fn note(problem: &mut String, subject: &str, written: Result<(), String>) {
    // A warning at the first failure only: the same one would follow with every decision.
    let was_fine = problem.is_empty();
    *problem = match written {
        Ok(()) => String::new(),
        Err(why) => format!("{subject} would lose its checkpoint: {why}"),
    };
    if was_fine && !problem.is_empty() {
        cell_worker::warn(format_args!("{problem}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robocell_task::starts::History as _;

    #[test]
    fn another_run_and_another_physics_are_not_remembered() {
        let dir = std::env::temp_dir().join(format!("robocell-slots-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let mut slots = Slots::open(&dir, 7).unwrap();
        assert!(slots.newest(1).is_none());
        let mut decision = Decision::zeroed();
        decision.drops = 3;
        for tick in [10, 20] {
            slots.write(1, tick, &decision, b"checkpoint");
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

    fn dir(name: &str) -> PathBuf {
        let dir = format!("robocell-slots-{name}-{}", std::process::id());
        let dir = std::env::temp_dir().join(dir);
        std::fs::create_dir_all(&dir).unwrap();
        dir
    }

    fn decide(slots: &mut Slots, generation: u32, ticks: std::ops::Range<u64>) {
        for tick in ticks.step_by(10) {
            let text = format!("{generation}: {tick}");
            slots.write(generation, tick, &Decision::zeroed(), text.as_bytes());
        }
    }

    fn found(slots: &Slots, tick: u64) -> Option<String> {
        let kept = slots.at(tick)?;
        Some(String::from_utf8(kept.checkpoint).unwrap())
    }

    #[test]
    fn the_checkpoint_of_a_saved_state_is_found_on_the_present_timeline() {
        let dir = dir("history");
        let mut slots = Slots::open(&dir, 7).unwrap();
        let keep = |slots: &mut Slots, tick, saved| slots.keep(tick, saved, &Vec::new);
        assert_eq!(found(&slots, 0), None);
        for second in 0..3 {
            decide(&mut slots, 1, second * 500..(second + 1) * 500);
            keep(&mut slots, (second + 1) * 500, second * 500);
        }
        decide(&mut slots, 1, 1_500..1_700);
        assert_eq!(found(&slots, 1_500).as_deref(), Some("1: 1490"));
        assert_eq!(found(&slots, 1_000).as_deref(), Some("1: 990"));
        assert_eq!(
            found(&slots, 1_690).as_deref(),
            Some("1: 1690"),
            "the newest"
        );
        // Physics goes back to 1000 and gets to 1750.
        decide(&mut slots, 2, 1_000..1_500);
        keep(&mut slots, 1_500, 1_000);
        decide(&mut slots, 2, 1_500..1_750);
        assert_eq!(found(&slots, 1_500).as_deref(), Some("2: 1490"));
        assert_eq!(found(&slots, 1_000).as_deref(), Some("1: 990"));
        // As another process reads it.
        let slots = Slots::open(&dir, 7).unwrap();
        assert_eq!(found(&slots, 1_500).as_deref(), Some("2: 1490"));
        assert_eq!(found(&Slots::open(&dir, 8).unwrap(), 1_500), None);
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn the_checkpoint_of_the_saved_state_stays_while_physics_cannot_save_another() {
        let dir = dir("stays");
        let mut slots = Slots::open(&dir, 7).unwrap();
        decide(&mut slots, 1, 0..500);
        slots.keep(500, 0, &Vec::new);
        for second in 1..60 {
            decide(&mut slots, 1, second * 500..(second + 1) * 500);
            slots.keep((second + 1) * 500, 500, &Vec::new);
        }
        assert_eq!(found(&slots, 500).as_deref(), Some("1: 490"));
        // And when the task was restarted meanwhile.
        let mut slots = Slots::open(&dir, 7).unwrap();
        slots.keep(30_100, 500, &Vec::new);
        assert_eq!(found(&slots, 500).as_deref(), Some("1: 490"));
        assert_eq!(found(&slots, 30_100).as_deref(), Some("1: 29990"));
        std::fs::remove_dir_all(&dir).unwrap();
    }

    #[test]
    fn a_checkpoint_of_16_mib_is_kept_and_a_longer_one_is_reported_with_the_limit() {
        let dir = dir("long");
        let mut slots = Slots::open(&dir, 7).unwrap();
        let longest = vec![5; MAX_BYTES];
        slots.write(1, 10, &Decision::zeroed(), b"short");
        slots.write(1, 20, &Decision::zeroed(), &longest);
        assert_eq!(slots.lost(), "");
        let newest = Slots::open(&dir, 7).unwrap().newest(1).unwrap();
        assert!(newest.tick == 20 && newest.checkpoint == longest);
        slots.write(1, 30, &Decision::zeroed(), &vec![5; MAX_BYTES + 1]);
        assert!(slots.lost().contains("16777216 bytes"), "{}", slots.lost());
        slots.write(1, 40, &Decision::zeroed(), b"short");
        assert_eq!(slots.lost(), "");
        std::fs::remove_dir_all(&dir).unwrap();
    }
}
