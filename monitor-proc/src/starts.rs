//! Processes that were started again, for the log and the timeline. The task says so
//! itself.

use ipc_types::Health;
use ipc_types::topic::Process;

/// The newest start of each process.
#[derive(Default)]
pub(crate) struct Starts {
    known: Vec<(Process, u32)>,
}

impl Starts {
    /// A line for each process whose newest start was not seen before.
    pub(crate) fn look(&mut self, processes: &[(Process, Option<&Health>)]) -> Vec<String> {
        let mut lines = Vec::new();
        for (process, health) in processes {
            let Some(health) = health else {
                continue;
            };
            let now = health.header.generation;
            match self.known.iter_mut().find(|(known, _)| known == process) {
                Some((_, known)) if *known < now => {
                    *known = now;
                    lines.extend(line(*process, now));
                }
                Some(_) => {}
                None => {
                    self.known.push((*process, now));
                    // The monitor does not see itself start.
                    let own = *process == Process::Monitor && now > 1;
                    lines.extend(own.then(|| line(*process, now)).flatten());
                }
            }
        }
        lines
    }
}

fn line(process: Process, start: u32) -> Option<String> {
    let name = process.name();
    (process != Process::Task).then(|| format!("[cell] {name} restarted: start {start}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    #[test]
    fn each_restart_is_told_once_and_a_first_look_is_none() {
        let mut starts = Starts::default();
        let health = |generation| {
            let mut health = Health::zeroed();
            health.header.generation = generation;
            health
        };
        let (one, two) = (health(1), health(2));
        let physics = Process::Physics;
        assert!(starts.look(&[(physics, None)]).is_empty());
        assert!(starts.look(&[(physics, Some(&one))]).is_empty());
        assert!(starts.look(&[(physics, None)]).is_empty());
        let lines = starts.look(&[(physics, Some(&two)), (Process::Task, Some(&one))]);
        assert_eq!(lines, ["[cell] physics restarted: start 2"]);
        assert!(
            starts
                .look(&[(physics, Some(&two)), (Process::Task, Some(&two))])
                .is_empty()
        );
        let lines = starts.look(&[(Process::Monitor, Some(&two))]);
        assert_eq!(lines, ["[cell] monitor restarted: start 2"]);
    }
}
