//! The state that physics resumes from after its process was killed.
//!
//! A kill at any instant costs at most one second of simulated time. What could break this,
//! and the rules against it:
//!
//! - Age: a state is saved every half second, and its write has the other half.
//! - Time: a write takes longer than a tick, so a separate thread does it.
//! - A kill during the write: the file is replaced as a whole ([`RecordFile`]), so states may
//!   have any size, and the previous state remains readable.
//! - The task: a state is announced in the message of its tick before it is written. The task
//!   keeps its checkpoint of an announced state, so the two always belong together.
//! - Requests: those accepted after the saved state are kept apart and obeyed again.
//! - Silence: a state that cannot be saved is reported at once, not at the kill.
//!
//! A change must not announce a state that is not handed over, nor hand over one of another
//! tick than the announced one.

pub(crate) mod due;
mod requests;
mod store;
#[cfg(test)]
mod tests;
mod writer;

use std::io;
use std::path::Path;

use cell_rt::{MemoryFile, RecordFile, SlotFile};
use ipc_types::{OperatorReply, OperatorRequest};

use crate::plant::{Plant, has_effect};
use due::{Due, MAX_LOST_TICKS};
use requests::{FILE as FILE_OF_REQUESTS, RECORD_BYTES, REQUESTS, Requests};
pub use store::Store;
use writer::Writer;

/// Name of the file in the run directory.
const FILE: &str = "physics.state";
/// Bytes before a state: identity of the run.
// A run directory may hold the state of an earlier run; its ticks mean nothing here.
const HEAD_BYTES: usize = 8;
/// In lockstep physics waits for a write that is running while its newest saved state
/// is older than this (ticks): no tick has to be in time there.
// Below [`MAX_LOST_TICKS`]: the wait ends before a loss has to be reported.
const LOCKSTEP_TICKS: u64 = 900;

/// Saves the state of physics.
pub(crate) struct Resume<S = Writer> {
    store: S,
    requests: Option<Requests>,
    run: u64,
    due: Due,
    /// Tick of the state that was announced and has to be handed over.
    announced: Option<u64>,
    /// Tick of the newest state that is in the file.
    saved_tick: u64,
    /// Why the last state could not be saved; empty if it could.
    problem: String,
    /// The loss when this process started; empty for none.
    lost: String,
}

impl Resume {
    /// Opens the files in `run_dir`. `plant`, just set up, is restored to the state of
    /// physics before this one if there `was_one`.
    pub(crate) fn open(run_dir: &Path, run: u64, was_one: bool, plant: &mut Plant) -> Self {
        let writer = Writer::start(RecordFile::new(&run_dir.join(FILE)));
        let requests = Requests::open(run_dir, run);
        Self::with(writer, requests, run, was_one, plant)
    }
}

impl<S: Store> Resume<S> {
    /// As [`Resume::open`], of a modelled physics.
    pub(crate) fn model(
        store: S,
        requests: &MemoryFile,
        run: u64,
        was_one: bool,
        plant: &mut Plant,
    ) -> Self {
        let file = SlotFile::in_memory(requests, RECORD_BYTES, REQUESTS);
        let requests = file.map(|file| Requests::of(file, run));
        Self::with(store, requests, run, was_one, plant)
    }

    /// As [`Resume::open`], with the states in `store`.
    fn with(
        store: S,
        requests: io::Result<Requests>,
        run: u64,
        was_one: bool,
        plant: &mut Plant,
    ) -> Self {
        let mut lost = String::new();
        // Without the file of requests physics still runs: a kill then loses what people asked
        // for.
        if let Err(error) = &requests {
            lost = format!("requests of a killed physics would be lost: {error}");
        }
        let requests = requests.ok();
        if was_one {
            // The reason of a failed restore replaces that of the requests: it is the larger
            // loss.
            lost = resume(&store, run, plant).err().unwrap_or(lost);
        }
        let tick = plant.world().tick();
        let due = Due {
            tick: (tick > 0).then_some(tick),
            switches: plant.switches(),
        };
        // After the restore: requests are repeated on the state they were accepted in.
        let repeated = requests.as_ref().filter(|_| was_one);
        let missing = repeated.map_or(0, |requests| requests.repeat(plant));
        if lost.is_empty() && missing > 0 {
            lost = format!("{missing} requests of people; ask again");
        }
        // The newest of them may be the one that is damaged: no number shows that it is missing.
        if lost.is_empty() && repeated.is_some_and(Requests::are_damaged) {
            lost = format!("requests of people in {FILE_OF_REQUESTS}, which is damaged; ask again");
        }
        if !lost.is_empty() {
            cell_worker::warn(format_args!("lost: {lost}"));
        }
        Self {
            store,
            requests,
            run,
            due,
            announced: None,
            saved_tick: tick,
            problem: String::new(),
            lost,
        }
    }

    /// Records a request that was answered, if a successor has to obey it again.
    pub(crate) fn note(&mut self, plant: &Plant, request: &OperatorRequest, reply: &OperatorReply) {
        let is_accepted = reply.code == ipc_types::operator::ReplyCode::Accepted.code();
        if let Some(requests) = &mut self.requests
            && is_accepted
            && has_effect(request)
        {
            requests.note(plant.accepted(), request);
        }
    }

    /// Called before the present state is published: the message contains whether it is saved.
    /// Returns the ticks to announce: of the newest state that is saved or being written, and
    /// of the newest that is saved.
    pub(crate) fn announce(&mut self, plant: &Plant) -> (u64, u64) {
        self.take_results();
        let tick = plant.world().tick();
        // A run that has ended is not saved any more: no successor continues it.
        let is_due = !plant.is_ending() && self.due.is_due(tick, plant.switches());
        // A state is only announced if the thread can take it now: an announced state that is
        // never written would leave the task with a checkpoint for nothing.
        if is_due && self.store.is_idle() {
            self.announced = Some(tick);
            self.due = Due {
                tick: Some(tick),
                switches: plant.switches(),
            };
        }
        (self.due.tick.unwrap_or(0), self.saved_tick)
    }

    /// To be called after it was published: hands the state over, if it was announced.
    pub(crate) fn save(&mut self, plant: &Plant) {
        let Some(tick) = self.announced.take() else {
            return;
        };
        // The tick is taken from the announcement; the plant has not stepped since.
        let run = self.run;
        self.store.write(tick, |bytes| {
            bytes.extend(run.to_le_bytes());
            plant.save_to(bytes);
        });
    }

    /// In lockstep: waits for the write that is running if the newest saved state is
    /// about to be too old.
    pub(crate) fn wait(&mut self, tick: u64) {
        // Waiting costs nothing in lockstep, where simulated time stops with it.
        let is_old = |this: &Self| tick.saturating_sub(this.saved_tick) > LOCKSTEP_TICKS;
        if is_old(self) && !self.store.is_idle() {
            self.store.wait();
            self.take_results();
        }
    }

    /// The loss a kill would cause now, or the one that happened at the start; empty for none.
    pub(crate) fn lost(&self, tick: u64) -> String {
        if tick.saturating_sub(self.saved_tick) <= MAX_LOST_TICKS {
            return self.lost.clone();
        }
        let saved_s = self.saved_tick as f64 / 1000.0;
        let why = if self.problem.is_empty() {
            "the write takes long"
        } else {
            &self.problem
        };
        format!("a kill of physics would go back to {saved_s:.1} s: no newer state is saved, {why}")
    }

    fn take_results(&mut self) {
        while let Some((tick, result)) = self.store.result() {
            match result {
                Ok(()) => {
                    self.saved_tick = tick;
                    self.problem.clear();
                }
                // Logged once per problem: a full disk fails at every write.
                Err(error) => {
                    if self.problem.is_empty() {
                        cell_worker::warn(format_args!(
                            "the state of physics is not saved: {error}"
                        ));
                    }
                    self.problem = error;
                }
            }
        }
    }
}

/// Restores `plant` to the newest state, or to the previous one if that is damaged.
///
/// # Errors
/// The loss, as a sentence for the log.
fn resume(store: &impl Store, run: u64, plant: &mut Plant) -> Result<(), String> {
    let Err(newest) = restore(store.read(), run, plant) else {
        return Ok(());
    };
    let path = store.name();
    match restore(store.read_older(), run, plant) {
        // A writer killed between its two renames leaves the older state only; nothing is
        // lost.
        Ok(()) if newest == MISSING => Ok(()),
        Ok(()) => {
            let s = plant.world().tick() as f64 / 1000.0;
            // Else the next write would move the damaged state over the only whole one, and a
            // kill between its two renames would leave none.
            let kept = store.replace_by_older();
            let kept = kept
                .err()
                .map(|error| format!("; it cannot be replaced: {error}"));
            let kept = kept.unwrap_or_default();
            Err(format!(
                "{path}: {newest}; physics resumed from the state before, of {s:.1} s{kept}"
            ))
        }
        Err(_) => Err(format!("{path}: {newest}; the scene starts again")),
    }
}

/// Reason for a state that does not exist.
const MISSING: &str = "it is missing";

fn restore(read: io::Result<Option<Vec<u8>>>, run: u64, plant: &mut Plant) -> Result<(), String> {
    let bytes = read.map_err(|error| error.to_string())?;
    let bytes = bytes.ok_or(MISSING)?;
    // Too short is an empty head, which is refused as a foreign run.
    let (head, state) = bytes.split_at_checked(HEAD_BYTES).unwrap_or_default();
    if head != run.to_le_bytes() {
        return Err("it is of another run".to_owned());
    }
    plant.restore(state).map_err(|error| error.to_string())
}
