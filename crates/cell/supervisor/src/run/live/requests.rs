//! Requests of clients of the control socket.

use cell_run::spec::PageSecrets;

use super::LiveCell;
use crate::control::Reply;
use crate::run::end::End;
use crate::run::wish::{Wish, consider, setting_up};

impl LiveCell {
    pub(super) fn answer_clients(&mut self, now: u64) {
        let mut asked = Vec::new();
        let (plan, planning) = (&mut self.cell.machine_mut().plan, &mut self.planning);
        let processes = &self.processes;
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
                Wish::End(end) => self.finish_with(now, end),
                Wish::Restart(which) => {
                    for process in which {
                        self.cell.restart(now, process);
                    }
                }
            }
        }
    }

    /// Takes the cell down for the scene that is planned now.
    pub(super) fn take_plan(&mut self, now: u64) {
        // A run that ends already tells the client at its end.
        let Some(planned) = self.planning.poll().filter(|_| self.end.is_none()) else {
            return;
        };
        match planned {
            Ok(mut next) => {
                // The monitor replaces a token that was used, also during the planning.
                let secrets = PageSecrets::load(&self.run_dir().page()).ok();
                next.secrets = next.secrets.map(|first| secrets.unwrap_or(first));
                self.control.answer(&Reply::accepted(setting_up(&next)));
                self.finish_with(now, End::Replaced(Box::new(next)));
            }
            Err(failure) if self.planning.is_for_client() => {
                self.control.answer(&Reply::refused(failure));
            }
            Err(failure) => self.finish_with(now, End::GaveUp(failure)),
        }
    }
}
