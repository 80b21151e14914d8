//! The loop around the supervisor: what happened in, what to do out.
//!
//! Time is an argument and everything outside is behind [`Machine`], so that a simulated
//! cell runs the same loop.

mod actions;
mod ending;
#[cfg(test)]
mod tests;

use cell_model::cells::script::ScriptLine;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

pub use ending::Verdict;

use super::faults::script::{FaultStep, Faults};
use super::faults::standstill::Standstill;
use super::faults::starvation::{Running, Starvation};
use super::machine::Machine;
use super::watch::Watch;
use crate::failure::Failure;
use crate::supervision::{Event, Rules, Supervisor};

/// How long the launcher's own ports may receive nothing before the run is given up (ns):
/// longer than any process is waited for, as a process that hangs in a port of the bus is
/// replaced first.
const DEAF_LIMIT_NS: u64 = 30_000_000_000;

/// A run, as far as its supervision depends on it.
#[derive(Clone, Debug)]
pub struct Terms {
    /// Name of the demo, for messages.
    pub demo: String,
    /// The processes of the cell.
    pub processes: Vec<Process>,
    /// How strict supervision is.
    pub rules: Rules,
    /// Lines of the script, of which those about processes are executed here.
    pub script: Vec<ScriptLine>,
    /// Whether a task that waits to be started is started.
    pub gives_start: bool,
    /// Whether a client program commands an arm: lockstep waits for it as long as it takes.
    pub has_clients: bool,
}

/// Supervises the processes of one run.
pub struct SupervisorLoop<M> {
    machine: M,
    terms: Terms,
    supervisor: Supervisor,
    watch: Watch,
    starvation: Starvation,
    faults: Faults,
    standstill: Standstill,
    has_room: bool,
    start_event_given: bool,
    /// Every process is being stopped.
    is_ending: bool,
    verdict: Option<Verdict>,
}

impl<M: Machine> SupervisorLoop<M> {
    /// Of a run on `machine`, on which no process runs yet.
    pub fn new(machine: M, terms: Terms) -> Self {
        let mut order = terms.processes.clone();
        // The monitor keeps the log, so it is there before the task's first line.
        order.sort_by_key(|process| *process == Process::Task);
        Self {
            machine,
            supervisor: Supervisor::new(&order, terms.rules),
            watch: Watch::new(&terms.processes),
            starvation: Starvation::default(),
            faults: Faults::new(&terms.script, &terms.processes),
            standstill: Standstill::default(),
            has_room: true,
            start_event_given: false,
            is_ending: false,
            verdict: None,
            terms,
        }
    }

    /// The processes and their bus.
    pub fn machine(&self) -> &M {
        &self.machine
    }

    /// The processes and their bus.
    pub fn machine_mut(&mut self) -> &mut M {
        &mut self.machine
    }

    /// The same, at the end.
    pub fn into_machine(self) -> M {
        self.machine
    }

    /// Which processes run and which were restarted.
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// The newest messages and signs of life of the processes.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// First half of a turn: takes note of what happened until `now` (ns), and executes the
    /// script's lines about processes.
    pub fn look(&mut self, now: u64) {
        let ended = self.machine.reap();
        let silence_ns = self.supervisor.longest_silence();
        self.machine
            .remove_half_made(now, !ended.is_empty(), silence_ns);
        // Before the exits: one for lack of room is not a crash.
        self.look_for_room(now);
        for (process, generation, exit) in ended {
            self.tell(
                now,
                Event::Exited {
                    process,
                    generation,
                    exit,
                },
            );
        }
        self.listen(now);
        // After `listen`, which adds to the silence: starvation counts up to that only.
        self.look_for_starvation(now);
        self.machine.note(now, &self.watch);
        self.look_for_the_end(now);
        self.execute_script(now);
    }

    /// Second half of a turn: executes the actions that are due at `now` (ns).
    pub fn act(&mut self, now: u64) {
        let mut actions = Vec::new();
        self.supervisor.poll(now, &mut actions);
        self.execute(now, actions);
    }

    /// Restarts `process` as a person asked for it.
    pub fn restart(&mut self, now: u64, process: Process) {
        self.tell(now, Event::Restart { process });
    }

    /// Kills every process at once.
    pub fn abort(&mut self, now: u64) {
        self.tell(now, Event::Abort);
    }

    /// Without room a process could not start; those that run keep their memory.
    fn look_for_room(&mut self, now: u64) {
        let lack = self.machine.lack_of_room();
        if lack.is_none() == self.has_room {
            return;
        }
        self.has_room = lack.is_none();
        self.machine.warn(&lack.map_or_else(
            || "there is room again for a process to start".to_owned(),
            |lack| format!("{lack}: a process that ends is started again when there is room"),
        ));
        self.tell(now, Event::Room(self.has_room));
    }

    /// Takes the messages of the processes.
    fn listen(&mut self, now: u64) {
        let news = self.machine.news(now);
        if let Some((OperatorAction::TaskStart, true)) = news.answer {
            self.start_event_given = true;
        }
        for event in self.watch.take(news) {
            self.tell(now, event);
        }
        while let Some(fault) = self.watch.next_fault() {
            self.machine.warn(&format!("fault of {fault}"));
        }
        // Until the last process has ended, this is still the bus that is being replaced.
        if self.machine.deaf_ns(now) <= DEAF_LIMIT_NS || self.supervisor.is_leaving_bus() {
            return;
        }
        if self.supervisor.has_left_bus() {
            let message = "the launcher has heard nothing from the cell's bus for 30 s: its shared \
                           memory is damaged; start the cell again";
            self.conclude(now, Verdict::GaveUp(Failure::gave_up(message)));
        } else {
            self.tell(now, Event::BusLost);
        }
    }

    fn look_for_starvation(&mut self, now: u64) {
        let of = |process: &Process| {
            Some(Running {
                process: *process,
                generation: self.supervisor.generation(*process),
                pid: self.machine.pid(*process)?,
                silence_ns: self.supervisor.silence(*process),
                leaves: self.supervisor.is_leaving(*process),
            })
        };
        let running: Vec<Running> = self.terms.processes.iter().filter_map(of).collect();
        let machine = &self.machine;
        let threads = |pid, all| machine.threads(pid, all);
        for event in self.starvation.look(now, &running, threads) {
            self.tell(now, event);
        }
    }

    fn warn_of_line(&mut self, line: u32, done: Result<(), String>) {
        if let Err(why) = done {
            self.machine
                .warn(&format!("line {line} of the script: {why}"));
        }
    }

    fn execute_script(&mut self, now: u64) {
        self.machine.end_disturbances(now);
        let line = self.watch.state().map_or(0, |state| state.script_line);
        let (machine, supervisor) = (&self.machine, &self.supervisor);
        let generation = |p: Process| machine.pid(p).map(|_| supervisor.generation(p));
        for step in self.faults.poll(now, line, generation) {
            match step {
                FaultStep::Kill(process) => {
                    let what = format!("{} was killed by the script", process.name());
                    self.machine.incident(now, process, &what);
                    self.tell(now, Event::KillAndRestart { process });
                }
                FaultStep::Restart(process, policy) => {
                    let chosen = policy.map_or(Ok(()), |policy| self.machine.choose(&policy));
                    self.warn_of_line(line, chosen);
                    self.restart(now, process);
                }
                FaultStep::Disturb(action) => {
                    let done = self.machine.disturb(now, &action);
                    self.warn_of_line(line, done);
                }
                FaultStep::Freeze(process) => self.machine.freeze(process),
                FaultStep::Thaw(process, generation) => {
                    if self.supervisor.generation(process) == generation {
                        self.machine.thaw(process);
                    }
                }
                FaultStep::Tell(line) => self.machine.ask(OperatorAction::ScriptDone, line),
            }
        }
    }
}
