//! Restarted processes, for the log and the timeline. The task writes its own lines.

use ipc_types::Health;
use ipc_types::topic::Process;

/// The newest start of each process.
#[derive(Default)]
pub(crate) struct Restarts {
    known: Vec<KnownStart>,
}

struct KnownStart {
    process: Process,
    start: u32,
    /// Time of its last message (simulated s).
    heard_s: f64,
}

/// A process that was restarted.
#[derive(Debug, PartialEq)]
pub(crate) struct Restart {
    pub(crate) process: Process,
    /// Time of the last message of the start before (simulated s).
    pub(crate) down_s: f64,
    start: u32,
}

impl Restarts {
    /// Processes with a start not seen before, at `time_s`.
    pub(crate) fn update(
        &mut self,
        processes: &[(Process, Option<&Health>)],
        time_s: f64,
    ) -> Vec<Restart> {
        let mut new = Vec::new();
        for (process, health) in processes {
            // A silent process keeps its last time: that is when it went down.
            let Some(health) = health else {
                continue;
            };
            let start = health.header.generation;
            let restart = |down_s| Restart {
                process: *process,
                down_s,
                start,
            };
            let mut known = self.known.iter_mut();
            if let Some(known) = known.find(|known| known.process == *process) {
                if known.start < start {
                    new.push(restart(known.heard_s));
                }
                (known.start, known.heard_s) = (start, time_s);
                continue;
            }
            self.known.push(KnownStart {
                process: *process,
                start,
                heard_s: time_s,
            });
            // The monitor does not see its own start.
            if *process == Process::Monitor && start > 1 {
                new.push(restart(time_s));
            }
        }
        new
    }
}

impl Restart {
    /// A line for the log; the task writes its own.
    pub(crate) fn line(&self) -> Option<String> {
        let (name, start) = (self.process.name(), self.start);
        (self.process != Process::Task).then(|| format!("[cell] {name} restarted: start {start}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    #[test]
    fn each_restart_is_told_once_and_a_first_look_is_none() {
        let mut restarts = Restarts::default();
        let health = |generation| {
            let mut health = Health::zeroed();
            health.header.generation = generation;
            health
        };
        let (one, two) = (health(1), health(2));
        let physics = Process::Physics;
        assert!(restarts.update(&[(physics, None)], 1.0).is_empty());
        assert!(restarts.update(&[(physics, Some(&one))], 2.0).is_empty());
        assert!(restarts.update(&[(physics, None)], 3.0).is_empty());
        let task = Process::Task;
        let new = restarts.update(&[(physics, Some(&two)), (task, Some(&one))], 4.0);
        let line = Some("[cell] physics restarted: start 2".to_owned());
        assert_eq!((new[0].line(), new[0].down_s, new.len()), (line, 2.0, 1));
        let both = [(physics, Some(&two)), (task, Some(&two))];
        // The task writes its own line.
        assert_eq!(restarts.update(&both, 5.0)[0].line(), None);
        let new = restarts.update(&[(Process::Monitor, Some(&two))], 6.0);
        let line = Some("[cell] monitor restarted: start 2".to_owned());
        assert_eq!(new[0].line(), line);
    }
}
