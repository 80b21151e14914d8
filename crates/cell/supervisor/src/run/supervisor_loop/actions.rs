//! The actions of the supervisor, carried out.

use ipc_types::topic::Process;

use super::{SupervisorLoop, Verdict};
use crate::failure::Failure;
use crate::run::faults::starvation;
use crate::run::machine::Machine;
use crate::run::watch::Watch;
use crate::supervision::{Action, Event};

impl<M: Machine> SupervisorLoop<M> {
    pub(super) fn tell(&mut self, now: u64, event: Event) {
        let mut actions = Vec::new();
        self.supervisor.handle(now, event, &mut actions);
        self.execute(now, actions);
    }

    pub(super) fn execute(&mut self, now: u64, actions: Vec<Action>) {
        for action in actions {
            match action {
                Action::Spawn {
                    process,
                    generation,
                } => self.spawn(now, process, generation),
                Action::LeaveBus { reason } => self.leave_bus(now, &reason),
                Action::NewBus => self.new_bus(now),
                Action::Terminate { process } => self.machine.terminate(process),
                Action::Kill { process } => self.machine.kill(process),
                Action::Ready => {}
                Action::Lost { process, what } => self.lost(now, process, &what),
                Action::Starves {
                    process,
                    starved_ns,
                    silent_ns,
                } => {
                    let report = starvation::report(process, starved_ns, silent_ns);
                    self.machine.incident(now, process, &report);
                    self.machine.warn(&report);
                }
                Action::GaveUp {
                    process,
                    refused: true,
                    ..
                } if process != Process::Monitor && !self.supervisor.is_ready() => {
                    self.refused(now, process);
                }
                Action::GaveUp {
                    process, reason, ..
                } => self.give_up(now, process, &reason),
            }
        }
    }

    fn spawn(&mut self, now: u64, process: Process, generation: u32) {
        if let Err(why) = self.machine.spawn(process, generation) {
            self.tell(
                now,
                Event::SpawnFailed {
                    process,
                    generation,
                    why,
                },
            );
        }
    }

    /// The supervisor ends every process, to start it on another bus.
    fn leave_bus(&mut self, now: u64, reason: &str) {
        let what = format!("the cell's shared memory is replaced: {reason}");
        let hint = self.machine.incident(now, Process::Physics, &what);
        self.machine
            .warn(&format!("{what}; every process is started again; {hint}"));
    }

    fn new_bus(&mut self, now: u64) {
        match self.machine.new_bus() {
            Ok(()) => {
                let watch = Watch::new(&self.terms.processes);
                self.watch = watch.with_faults_of(&mut self.watch);
            }
            Err(failure) => self.conclude(now, Verdict::GaveUp(Failure::gave_up(failure))),
        }
    }

    /// A process ended or hangs, and is started again.
    fn lost(&mut self, now: u64, process: Process, what: &str) {
        let words = self.words_at_exit(process, what);
        let what = format!("{} {what}{words}", process.name());
        let hint = self.machine.incident(now, process, &what);
        self.machine
            .warn(&format!("{what}; it is started again; {hint}"));
    }

    /// What a process wrote last, where it ended by itself with an error: the exception of
    /// a task in Python, a panic. `what` is from the supervisor.
    fn words_at_exit(&self, process: Process, what: &str) -> String {
        if !what.starts_with("ended with exit code") && !what.starts_with("panicked") {
            return String::new();
        }
        let lines = self.machine.last_words(process, 1);
        lines.last().map_or_else(String::new, |line| {
            format!(": {}", line.strip_prefix("warning: ").unwrap_or(line))
        })
    }

    /// A process found at its start that the cell cannot exist: that is the answer.
    fn refused(&mut self, now: u64, process: Process) {
        let name = process.name();
        let prefix = format!("{}-proc: ", name.split('-').next().unwrap_or_default());
        let lines = self.machine.last_words(process, 1);
        let said = lines.last().map_or("(it wrote nothing)", |line| {
            line.strip_prefix(&prefix).unwrap_or(line)
        });
        let message = format!("{}: {said}", self.terms.demo);
        self.conclude(now, Verdict::GaveUp(Failure::configuration(message)));
    }

    /// Without its monitor a cell still works; without any other it does not.
    fn give_up(&mut self, now: u64, process: Process, reason: &str) {
        let name = process.name();
        let what = format!("{name} is given up: {reason}");
        self.machine.incident(now, process, &what);
        let lines = self.machine.last_words(process, 10);
        let log = if lines.is_empty() {
            "(it wrote nothing)".to_owned()
        } else {
            lines.join("\n  ")
        };
        if process == Process::Monitor {
            self.machine.warn(&format!(
                "{name} has stopped: {reason}. The cell runs without its page and recorder; {name} \
                 is tried again in 30 s, or by `robocell restart monitor`. Its last words:\n  {log}"
            ));
        } else {
            let message = format!("{what}. Its last words:\n  {log}");
            self.conclude(now, Verdict::GaveUp(Failure::gave_up(message)));
        }
    }
}
