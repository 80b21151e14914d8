//! The checkpoints of the task, each with the decision it led to, in files that
//! outlive the process: the newest two, for a successor of this process, and those for
//! the states that physics saved, for a successor of physics.

use std::path::{Path, PathBuf};

use cell_rt::SlotFile;
use ipc_types::{Decision, Wire};
use serde::{Deserialize, Serialize};

use robocell_task::checkpoint::{self, MAX_BYTES};
use robocell_task::starts::{History, Kept};

/// Names of the files in the run directory.
const FILE: &str = "task.slots";
const HISTORY_FILE: &str = "task.history";
/// Entries of the history: for the state that physics saved last, for one that is
/// being written, and two before, in case a process is killed between these.
const HISTORY: usize = 4;
/// Room for a checkpoint at the start; longer ones make more (bytes).
const FIRST_ROOM: usize = 64 * 1024;

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
    /// The entry written last.
    buffer: Vec<u8>,
    /// By slot of the history: the state that its entry is for, and its number.
    labels: [Option<(u64, u64)>; HISTORY],
    /// Why the entry written last, and that of the history, are not in their files;
    /// empty if they are.
    problem: String,
    history_problem: String,
    /// What was damaged at the start.
    damage: String,
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
        let capacity = HEAD_BYTES + size_of::<Decision>() + FIRST_ROOM;
        let mut damage = String::new();
        let mut open = |name: &str, slots: usize| {
            let path = run_dir.join(name);
            let file = SlotFile::with_slots(&path, capacity, slots);
            if file.as_ref().is_ok_and(SlotFile::was_damaged) {
                let path = path.display();
                damage = format!("checkpoints in {path}, which is damaged");
                cell_worker::warn(format_args!("lost: {damage}"));
            }
            file.map_err(|source| SlotsError { path, source })
        };
        let (file, history) = (open(FILE, 2)?, open(HISTORY_FILE, HISTORY)?);
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
        if self.damage.is_empty() && self.file.newest().is_none() {
            "the checkpoint of the task before; it decides from what it observes"
                .clone_into(&mut self.damage);
            cell_worker::warn(format_args!("lost: {}", self.damage));
        }
    }

    /// The newest entry of this run and this start of physics.
    pub fn newest(&self, physics_generation: u32) -> Option<Saved> {
        let (_, bytes) = self.file.newest()?;
        let (head, saved) = self.entry(&bytes)?;
        (head.physics_generation == physics_generation).then_some(saved)
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

    /// Writes an entry; one that cannot be kept is reported by [`Slots::lost`].
    pub fn write(
        &mut self,
        physics_generation: u32,
        tick: u64,
        decision: &Decision,
        checkpoint: &[u8],
    ) {
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
        let written = if checkpoint.len() > MAX_BYTES {
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

    /// Slots of the history with the newest entries first, without those of a time that
    /// physics went back before.
    fn on_this_timeline(&self) -> Vec<(usize, u64)> {
        let labels = self.labels.iter().enumerate();
        let mut slots: Vec<_> = labels
            .filter_map(|(slot, label)| label.map(|(label, seq)| (slot, label, seq)))
            .collect();
        slots.sort_by_key(|(.., seq)| core::cmp::Reverse(*seq));
        let mut earliest = u64::MAX;
        let is_current = move |(_, label, _): &(usize, u64, u64)| {
            let is_current = *label < earliest;
            earliest = earliest.min(*label);
            is_current
        };
        let slots = slots.into_iter().filter(is_current);
        slots.map(|(slot, label, _)| (slot, label)).collect()
    }

    /// The slot with the entry for the state of `tick`, and its label.
    fn find(&self, tick: u64) -> Option<(usize, u64)> {
        let slots = self.on_this_timeline();
        slots.into_iter().find(|(_, label)| *label <= tick)
    }

    fn read_history(&self, slot: usize, label: u64) -> Option<Kept> {
        let (.., bytes) = self
            .history
            .all_slots()
            .find(|(found, ..)| *found == slot)?;
        let (_, saved) = self.entry(&bytes)?;
        Some(Kept {
            tick: label,
            checkpoint: saved.checkpoint,
        })
    }
}

impl History for Slots {
    fn at(&self, tick: u64) -> Option<Kept> {
        let found = self.find(tick);
        if let Some((slot, label)) = found.filter(|(_, label)| *label == tick) {
            return self.read_history(slot, label);
        }
        let newest = self.file.newest();
        let newest = newest.and_then(|(_, bytes)| self.entry(&bytes));
        if let Some((head, saved)) = newest.filter(|(head, _)| head.tick <= tick) {
            return Some(Kept {
                tick: head.tick,
                checkpoint: saved.checkpoint,
            });
        }
        let (slot, label) = found?;
        self.read_history(slot, label)
    }

    /// The checkpoint is the entry written last.
    fn keep(&mut self, tick: u64, saved_tick: u64, _checkpoint: &dyn Fn() -> Vec<u8>) {
        if self.buffer.is_empty() {
            // The process before wrote it.
            self.buffer = self.file.newest().unwrap_or_default().1;
        }
        let head = self
            .buffer
            .get(..HEAD_BYTES)
            .map(checkpoint::from_bytes::<Head>);
        // One that is too long is not there, and was reported.
        let Some(Ok(mut head)) = head else {
            return;
        };
        head.label = tick;
        self.buffer
            .splice(..HEAD_BYTES, checkpoint::to_bytes(&head));
        let needed = self.find(saved_tick).map(|(slot, _)| slot);
        let slots = (0..HISTORY).filter(|slot| Some(*slot) != needed);
        let number = |slot: &usize| {
            self.labels
                .get(*slot)
                .copied()
                .flatten()
                .map(|(_, seq)| seq)
        };
        let Some(oldest) = slots.min_by_key(number) else {
            return;
        };
        self.history_seq += 1;
        let written = self
            .history
            .write_at(oldest, self.history_seq, &self.buffer);
        if let Some(label) = self.labels.get_mut(oldest) {
            *label = written.is_ok().then_some((tick, self.history_seq));
        }
        let written = written.map_err(|error| error.to_string());
        note(
            &mut self.history_problem,
            "the task, after a kill of physics,",
            written,
        );
    }
}

fn note(problem: &mut String, subject: &str, written: Result<(), String>) {
    let was_fine = problem.is_empty();
    *problem = match written {
        Ok(()) => String::new(),
        Err(why) => format!("{subject} would lose its checkpoint: {why}"),
    };
    if was_fine && !problem.is_empty() {
        cell_worker::warn(format_args!("{problem}"));
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
