//! What physics resumes from after its process was killed: its state of a moment ago,
//! in a two-slot file in the run directory.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use cell_rt::SlotFile;
use ipc_types::RESUME_TICKS;

use crate::plant::Plant;

/// Name of the file in the run directory.
const FILE: &str = "physics.slots";
/// A state is never older than this (ticks).
const LONGEST_TICKS: u64 = 1000;
/// Contacts come and go, so a state can be longer than the first by this factor.
const GROWTH: usize = 3;
/// Bytes before a state: identity of the run.
const HEAD_BYTES: usize = 8;

/// Keeps the state of physics. Writing is left to a thread: it takes longer than a
/// tick.
pub(crate) struct Resume {
    states: Option<SyncSender<Vec<u8>>>,
    writer: Option<JoinHandle<()>>,
    run: u64,
    kept_tick: u64,
    /// Whether what is not in the world was as it is now when it was kept.
    kept_switches: Switches,
}

/// What a person changed, as far as it is not a matter of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Switches {
    pub(crate) paused: bool,
    /// Requests obeyed so far.
    pub(crate) requests: u64,
}

impl Resume {
    /// Opens the file in `run_dir`. `plant`, just set up, is set to the state of
    /// physics before this one if there `was_one`.
    pub(crate) fn open(run_dir: &Path, run: u64, was_one: bool, plant: &mut Plant) -> Self {
        let room = HEAD_BYTES + GROWTH * plant.save().len();
        let path: PathBuf = run_dir.join(FILE);
        let file = SlotFile::open(&path, room);
        let file = file.map_err(|error| {
            let path = path.display();
            cell_worker::warn(format_args!(
                "{path}: {error}; physics starts from the beginning if it is killed"
            ));
        });
        if let (true, Ok(file)) = (was_one, &file) {
            resume(file, run, plant);
        }
        let (states, writer) = file.ok().and_then(writer).unzip();
        Self {
            states,
            writer,
            run,
            kept_tick: plant.world().tick(),
            kept_switches: plant.switches(),
        }
    }

    /// Keeps the state if it is time to.
    pub(crate) fn turn(&mut self, plant: &Plant) {
        let (tick, switches) = (plant.world().tick(), plant.switches());
        let age = tick.saturating_sub(self.kept_tick);
        let changed = switches != self.kept_switches;
        let is_due = if switches.paused || tick < self.kept_tick {
            changed || tick < self.kept_tick
        } else {
            tick.is_multiple_of(RESUME_TICKS) && (changed || age >= LONGEST_TICKS)
        };
        if !is_due || plant.is_ending() {
            return;
        }
        let Some(states) = &self.states else {
            return;
        };
        let mut state = self.run.to_le_bytes().to_vec();
        state.extend(plant.save());
        match states.try_send(state) {
            Ok(()) => {
                self.kept_tick = tick;
                self.kept_switches = switches;
            }
            // The one before is still being written: this one comes a little later.
            Err(TrySendError::Full(_)) => {}
            Err(TrySendError::Disconnected(_)) => self.states = None,
        }
    }
}

impl Drop for Resume {
    fn drop(&mut self) {
        self.states = None;
        if let Some(writer) = self.writer.take() {
            // It has nothing to say.
            let _ended = writer.join().is_ok();
        }
    }
}

fn resume(file: &SlotFile, run: u64, plant: &mut Plant) {
    let newest = file.newest();
    let ours = newest.as_ref().and_then(|(_, bytes)| {
        let (head, state) = bytes.split_at_checked(HEAD_BYTES)?;
        (head == run.to_le_bytes()).then_some(state)
    });
    if file.was_damaged() {
        cell_worker::warn(format_args!(
            "{FILE} in the run directory is damaged: physics may start from the beginning"
        ));
    }
    let Some(state) = ours else {
        cell_worker::warn(format_args!(
            "physics before this one kept no state; the scene starts again"
        ));
        return;
    };
    if let Err(error) = plant.restore(state) {
        cell_worker::warn(format_args!("{error}"));
    }
}

fn writer(mut file: SlotFile) -> Option<(SyncSender<Vec<u8>>, JoinHandle<()>)> {
    let (states, to_write) = sync_channel::<Vec<u8>>(1);
    let mut seq = file.newest().map_or(0, |(seq, _)| seq);
    let work = move || {
        for state in to_write {
            seq += 1;
            if !file.write(seq, &state) {
                cell_worker::warn(format_args!(
                    "a state of {} bytes is too long to be kept",
                    state.len()
                ));
            }
        }
    };
    let thread = std::thread::Builder::new().name("resume".to_owned());
    let thread = thread.spawn(work).ok()?;
    Some((states, thread))
}
