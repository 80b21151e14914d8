//! Requests to the launcher: of the script and of clients of the control socket.

use cell_model::runs::spec::PageSecrets;
use cell_rt::process::{SIGCONT, SIGSTOP};
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;

use super::{End, LiveCell};
use crate::control::Reply;
use crate::run::faults::FaultStep;
use crate::run::wish::{Wish, consider, setting_up};
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
        let (plan, planning, processes) = (&mut self.plan, &mut self.planning, &self.processes);
        self.control.poll(
            |request| match consider(plan, planning, processes, request) {
                Ok(Some((wish, message))) => {
                    asked.push(wish);
                    Some(Reply::accepted(message))
                }
                Ok(None) => None,
                Err(failure) => Some(Reply::refused(failure)),
            },
        );
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

    /// Takes the cell down for the scene that is planned now.
    pub(super) fn take_plan(&mut self) {
        // A run that ends already tells the client at its end.
        let Some(planned) = self.planning.poll().filter(|_| self.end.is_none()) else {
            return;
        };
        match planned {
            Ok(mut next) => {
                // The monitor replaces a token that was used, also during the planning.
                let secrets = PageSecrets::load(&self.plan.dir.page()).ok();
                next.secrets = next.secrets.map(|first| secrets.unwrap_or(first));
                self.control.answer(&Reply::accepted(setting_up(&next)));
                self.finish_with(End::Replaced(Box::new(next)));
            }
            Err(failure) if self.planning.is_for_client() => {
                self.control.answer(&Reply::refused(failure));
            }
            Err(failure) => self.finish_with(End::GaveUp(failure)),
        }
    }
}
