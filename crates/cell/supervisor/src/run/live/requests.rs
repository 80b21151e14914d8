//! Requests to the launcher: of the script and of clients of the control socket.

use cell_rt::process::{SIGCONT, SIGSTOP};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use super::LiveCell;
use crate::control::Reply;
use crate::run::faults::FaultStep;
use crate::run::wish::{Wish, consider};
use crate::supervision::Event;

impl LiveCell {
    pub(super) fn act_on_script(&mut self, now: u64) {
        let line = self.watch.state().map_or(0, |state| state.script_line);
        let (children, supervisor) = (&self.children, &self.supervisor);
        let generation = |p: Process| children.pid(p).map(|_| supervisor.generation(p));
        for step in self.faults.poll(now, line, generation) {
            match step {
                FaultStep::Kill(process) => {
                    let what = format!("{} was killed by the script", process.name());
                    self.incidents.failed(now, process, &what);
                    self.tell(now, Event::KillAndRestart { process });
                }
                FaultStep::Freeze(process) => self.children.signal(process, SIGSTOP),
                FaultStep::Thaw(process, generation) => {
                    if self.supervisor.generation(process) == generation {
                        self.children.signal(process, SIGCONT);
                    }
                }
                FaultStep::Tell(line) => self.bus.ask(OperatorAction::ScriptDone, line),
            }
        }
    }

    pub(super) fn answer_clients(&mut self, now: u64) {
        let mut asked = Vec::new();
        let (plan, processes) = (&mut self.plan, &self.processes);
        self.control
            .poll(|request| match consider(plan, processes, request) {
                Ok((wish, message)) => {
                    asked.push(wish);
                    Reply { ok: true, message }
                }
                Err(failure) => Reply {
                    ok: false,
                    message: failure.to_string(),
                },
            });
        for wish in asked {
            match wish {
                Wish::End(end) => self.finish_with(end),
                Wish::Restart(which) => {
                    for process in which {
                        self.tell(now, Event::Restart { process });
                    }
                }
            }
        }
    }
}
