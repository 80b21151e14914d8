//! The supervisor as a pure state machine: (time, event) in, actions out.
//!
//! Time is monotonic nanoseconds and always an argument, so that every order
//! of events can be tried in a test. `run/supervisor_loop/actions.rs`
//! executes the actions, `child.rs` starts and signals the processes.

mod event;
mod slot;
#[cfg(test)]
mod tests;

pub use event::{Action, Event, Exit, Rules};

use ipc_types::topic::Process;
use slot::{Lifecycle, MAX_HUNG_STARTS, Slot};

/// Nanoseconds in a millisecond.
pub(crate) const MS: u64 = 1_000_000;

/// State of the cell as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Keeping every process up.
    Keeping,
    /// Ending every process, to start again on a new bus.
    LeavingBus,
    /// Stopping in reverse order.
    Stopping,
}

/// Keeps the processes of one cell running.
#[derive(Clone, Debug)]
pub struct Supervisor {
    rules: Rules,
    phase: Phase,
    was_ready: bool,
    /// The bus was replaced: it is not done twice.
    left_bus: bool,
    /// Without room no process starts, and none that ends is to blame.
    has_room: bool,
    slots: Vec<Slot>,
}

impl Supervisor {
    /// A supervisor of `processes`, started in that order.
    pub fn new(processes: &[Process], rules: Rules) -> Self {
        let slots = processes.iter().map(|p| Slot::new(*p)).collect();
        Self {
            rules,
            phase: Phase::Keeping,
            was_ready: false,
            left_bus: false,
            has_room: true,
            slots,
        }
    }

    /// Whether physics waits for every process, from now on.
    pub fn set_lockstep(&mut self, lockstep: bool) {
        self.rules.lockstep = lockstep;
    }

    /// Whether every process has shown itself since the start of the cell.
    pub fn is_ready(&self) -> bool {
        self.was_ready
    }

    /// Whether the bus was replaced: it is not done twice.
    pub fn has_left_bus(&self) -> bool {
        self.left_bus
    }

    /// Whether processes are ended to start again on another bus.
    pub fn is_leaving_bus(&self) -> bool {
        self.phase == Phase::LeavingBus
    }

    /// Whether no process is left.
    pub fn is_down(&self) -> bool {
        self.slots.iter().all(|slot| slot.state == Lifecycle::Down)
    }

    /// For how long the most silent process has given no sign of life (ns).
    pub fn longest_silence(&self) -> u64 {
        let silences = self.slots.iter().map(Slot::silence);
        silences.max().unwrap_or(0)
    }

    /// For how long `process` has given no sign of life (ns), while it should.
    pub fn silence(&self, process: Process) -> u64 {
        let slot = self.slots.iter().find(|slot| slot.process == process);
        slot.map_or(0, Slot::silence)
    }

    /// Whether `process` was asked to end, and has not ended.
    pub fn is_leaving(&self, process: Process) -> bool {
        let mut slots = self.slots.iter();
        let slot = slots.find(|slot| slot.process == process);
        slot.is_some_and(|slot| matches!(slot.state, Lifecycle::Leaving(_)))
    }

    /// Which start of `process` is the newest; 0: none yet.
    pub fn generation(&self, process: Process) -> u32 {
        self.slots
            .iter()
            .find(|s| s.process == process)
            .map_or(0, |s| s.generation)
    }

    /// Restarts of `process` so far.
    pub fn restarts(&self, process: Process) -> u32 {
        self.generation(process).saturating_sub(1)
    }

    /// Takes note of `event` at `now`.
    pub fn handle(&mut self, now: u64, event: Event, out: &mut Vec<Action>) {
        match event {
            Event::Health {
                process,
                generation,
                cycles,
                fifo,
            } => {
                if let Some(slot) = self.slot(process, generation) {
                    slot.alive(cycles, fifo);
                }
                self.note_ready(out);
            }
            Event::Listened { ns } => self.slots.iter_mut().for_each(|slot| slot.listened(ns)),
            Event::Starved {
                process,
                generation,
                ns,
            } => self.with(process, generation, |slot| slot.starved(ns)),
            Event::Dying {
                process,
                generation,
            } => self.with(process, generation, |slot| slot.dying = true),
            Event::Exited {
                process,
                generation,
                exit,
            } => self.exited(now, process, generation, exit, out),
            Event::SpawnFailed {
                process,
                generation,
                why,
            } => {
                let keep = self.phase == Phase::Keeping;
                if let Some(slot) = self.slot(process, generation) {
                    slot.state = Lifecycle::Down;
                    if keep {
                        slot.give_up(now, why, out);
                    }
                }
            }
            Event::Restart { process } => self.restart(now, process, true),
            Event::KillAndRestart { process } => self.restart(now, process, false),
            Event::Room(has_room) => self.has_room = has_room,
            Event::BusLost => {
                if self.phase == Phase::Keeping && !self.left_bus {
                    self.leave_bus("the launcher hears nothing on it", out);
                }
            }
            Event::Stop => self.phase = Phase::Stopping,
            Event::Abort => self.abort(out),
        }
    }

    /// The actions that are due at `now`.
    pub fn poll(&mut self, now: u64, out: &mut Vec<Action>) {
        match self.phase {
            Phase::Keeping => self.keep(now, out),
            Phase::LeavingBus => self.new_bus(out),
            Phase::Stopping => self.stop_next(now, out),
        }
    }

    fn slot(&mut self, process: Process, generation: u32) -> Option<&mut Slot> {
        self.slots
            .iter_mut()
            .find(|s| s.process == process && s.generation == generation)
    }

    fn with(&mut self, process: Process, generation: u32, change: impl FnOnce(&mut Slot)) {
        if let Some(slot) = self.slot(process, generation) {
            change(slot);
        }
    }

    fn note_ready(&mut self, out: &mut Vec<Action>) {
        if !self.was_ready && self.slots.iter().all(|s| s.state == Lifecycle::Up) {
            self.was_ready = true;
            out.push(Action::Ready);
        }
    }

    fn exited(
        &mut self,
        now: u64,
        process: Process,
        generation: u32,
        exit: Exit,
        out: &mut Vec<Action>,
    ) {
        let (phase, left_bus, has_room) = (self.phase, self.left_bus, self.has_room);
        let Some(slot) = self.slot(process, generation) else {
            return;
        };
        match phase {
            Phase::Keeping if slot.never_works() && !left_bus => {
                // It has ended: `leave_bus` must not kill it and then wait for its end.
                slot.state = Lifecycle::NotStarted;
                let name = process.name();
                let reason = format!("{name} gave no sign of life in {MAX_HUNG_STARTS} starts");
                self.leave_bus(&reason, out);
            }
            Phase::Keeping if !has_room => slot.ended_without_room(now, exit, out),
            Phase::Keeping => slot.exited(now, exit, out),
            Phase::LeavingBus => slot.state = Lifecycle::NotStarted,
            Phase::Stopping => slot.state = Lifecycle::Down,
        }
    }

    /// The last resort against damaged shared memory.
    fn leave_bus(&mut self, reason: &str, out: &mut Vec<Action>) {
        self.left_bus = true;
        self.phase = Phase::LeavingBus;
        out.push(Action::LeaveBus {
            reason: reason.to_owned(),
        });
        // Not SIGTERM: a process that waits in damaged shared memory does not react to it.
        self.slots
            .iter_mut()
            .filter(|slot| slot.runs())
            .for_each(|slot| slot.kill(out));
    }

    /// As soon as no process is left on the old bus.
    fn new_bus(&mut self, out: &mut Vec<Action>) {
        if !self.slots.iter().any(Slot::runs) {
            self.slots.iter_mut().for_each(Slot::begin_again);
            self.phase = Phase::Keeping;
            out.push(Action::NewBus);
        }
    }

    fn restart(&mut self, now: u64, process: Process, gently: bool) {
        if self.phase == Phase::Keeping
            && let Some(slot) = self.slots.iter_mut().find(|s| s.process == process)
        {
            slot.ask_restart(now, gently);
        }
    }

    fn abort(&mut self, out: &mut Vec<Action>) {
        self.phase = Phase::Stopping;
        for slot in &mut self.slots {
            slot.forget_plans();
            if slot.runs() {
                slot.state = Lifecycle::Killed;
                out.push(Action::Kill {
                    process: slot.process,
                });
            }
        }
    }

    /// Starts processes that are due, in order, and looks for hangs.
    fn keep(&mut self, now: u64, out: &mut Vec<Action>) {
        let mut may_start = self.has_room;
        for slot in &mut self.slots {
            slot.keep(now, self.rules, may_start, self.has_room, out);
            // A cell runs without a monitor that was given up.
            may_start &= slot.state == Lifecycle::Up || slot.is_given_up();
        }
    }

    /// Stops the last process that runs; those before it wait for their turn.
    fn stop_next(&mut self, now: u64, out: &mut Vec<Action>) {
        for slot in &mut self.slots {
            slot.forget_plans();
        }
        if let Some(slot) = self.slots.iter_mut().rev().find(|s| s.runs()) {
            slot.stop(now, out);
        }
    }
}
