//! The actions of the supervisor, carried out.

use ipc_types::topic::Process;

use super::{End, LiveCell};
use crate::child::last_words;
use crate::failure::Failure;
use crate::run::starvation;
use crate::say;
use crate::supervision::{Action, Event};

impl LiveCell {
    pub(super) fn tell(&mut self, now: u64, event: Event) {
        let mut actions = Vec::new();
        self.supervisor.handle(now, event, &mut actions);
        self.obey(now, actions);
    }

    pub(super) fn obey(&mut self, now: u64, actions: Vec<Action>) {
        for action in actions {
            match action {
                Action::Spawn {
                    process,
                    generation,
                } => {
                    if let Err(why) = self.children.spawn(process, generation) {
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
                Action::LeaveBus { reason } => self.leave_bus(now, &reason),
                Action::NewBus => {
                    if let Err(failure) = self.new_bus() {
                        self.finish_with(End::GaveUp(Failure::gave_up(failure)));
                    }
                }
                Action::Terminate { process } => self.children.terminate(process),
                Action::Kill { process } => self.children.kill(process),
                Action::Ready => {}
                Action::Lost { process, what } => self.lost(now, process, &what),
                Action::Starves {
                    process,
                    starved_ns,
                    silent_ns,
                } => {
                    let report = starvation::report(process, starved_ns, silent_ns);
                    self.incidents.failed(now, process, &report);
                    say::warn(report);
                }
                Action::GaveUp {
                    process,
                    refused: true,
                    ..
                } if process != Process::Monitor && !self.is_ready() => self.refused(process),
                Action::GaveUp {
                    process, reason, ..
                } => self.give_up(now, process, &reason),
            }
        }
    }

    /// The supervisor ends every process, to start it on another bus.
    fn leave_bus(&mut self, now: u64, reason: &str) {
        let what = format!("the cell's shared memory is replaced: {reason}");
        let number = self.incidents.failed(now, Process::Physics, &what);
        let hint = self.incidents.hint(number);
        say::warn(format_args!(
            "{what}; every process is started again; {hint}"
        ));
    }

    /// A process ended or hangs, and is started again.
    fn lost(&mut self, now: u64, process: Process, what: &str) {
        let words = self.words_at_exit(process, what);
        let what = format!("{} {what}{words}", process.name());
        let number = self.incidents.failed(now, process, &what);
        let hint = self.incidents.hint(number);
        say::warn(format_args!("{what}; it is started again; {hint}"));
    }

    /// What a process wrote last, where it ended by itself with an error: the exception of
    /// a task in Python, a panic. `what` is from the supervisor.
    fn words_at_exit(&self, process: Process, what: &str) -> String {
        if !what.starts_with("ended with exit code") && !what.starts_with("panicked") {
            return String::new();
        }
        let lines = last_words(&self.plan.dir.log(&process.name()), 1);
        lines.last().map_or_else(String::new, |line| {
            format!(": {}", line.strip_prefix("warning: ").unwrap_or(line))
        })
    }

    /// A process found at its start that the cell cannot exist: that is the answer.
    fn refused(&mut self, process: Process) {
        let name = process.name();
        let prefix = format!("{}-proc: ", name.split('-').next().unwrap_or_default());
        let lines = last_words(&self.plan.dir.log(&name), 1);
        let said = lines.last().map_or("(it wrote nothing)", |line| {
            line.strip_prefix(&prefix).unwrap_or(line)
        });
        self.finish_with(End::GaveUp(Failure::configuration(format!(
            "{}: {said}",
            self.plan.spec.demo
        ))));
    }

    /// Without its monitor a cell still works; without any other it does not.
    fn give_up(&mut self, now: u64, process: Process, reason: &str) {
        let name = process.name();
        let what = format!("{name} is given up: {reason}");
        self.incidents.failed(now, process, &what);
        let lines = last_words(&self.plan.dir.log(&name), 10);
        let log = if lines.is_empty() {
            "(it wrote nothing)".to_owned()
        } else {
            lines.join("\n  ")
        };
        if process == Process::Monitor {
            say::warn(format_args!(
                "{name} has stopped: {reason}. The cell runs without its page and recorder; {name} \
                 is tried again in 30 s, or by `robocell restart monitor`. Its last words:\n  {log}"
            ));
        } else {
            self.finish_with(End::GaveUp(Failure::gave_up(format!(
                "{name} is given up: {reason}. Its last words:\n  {log}"
            ))));
        }
    }
}
