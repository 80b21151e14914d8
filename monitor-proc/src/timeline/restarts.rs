//! Restarted processes, for the log and the timeline. The task writes its own lines.

use crate::replay::clock::TICK_S;
use ipc_types::Health;
use ipc_types::topic::Process;

/// The newest start of each process.
#[derive(Default)]
pub(crate) struct Restarts {
    known: Vec<KnownStart>,
    clock: Clock,
}

/// Simulated time of the newest start of physics, and the last one of the start before (s).
#[derive(Default)]
struct Clock {
    start: u32,
    time_s: f64,
    before_s: f64,
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
    /// Takes the time of a state of the world; `start` is the one of physics that published it.
    pub(crate) fn take_time(&mut self, start: u32, time_s: f64) {
        if self.clock.start != start {
            (self.clock.start, self.clock.before_s) = (start, self.clock.time_s);
        }
        self.clock.time_s = time_s;
    }

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
                    let of_physics = *process == Process::Physics && self.clock.start == start;
                    // Each state is seen, the health only at times.
                    new.push(restart(if of_physics {
                        self.clock.before_s
                    } else {
                        known.heard_s
                    }));
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
    /// A line for the log; the task writes its own. `resumed_s` is the time from which the newest
    /// start of physics continues (simulated s).
    pub(crate) fn line(&self, resumed_s: f64) -> Option<String> {
        let (name, start) = (self.process.name(), self.start);
        let line = format!("[cell] {name} restarted: start {start}");
        match self.process {
            Process::Task => None,
            Process::Physics => Some(format!("{line}, {}", self.step_back(resumed_s))),
            _ => Some(line),
        }
    }

    /// What a reader of the events needs to see that time is repeated.
    fn step_back(&self, resumed_s: f64) -> String {
        let back_s = self.down_s - resumed_s;
        if resumed_s <= 0.0 {
            return "from the beginning: no saved state".to_owned();
        }
        if back_s < TICK_S {
            return format!("resumed at {resumed_s:.3} s");
        }
        format!("stepped back {back_s:.2} s, to {resumed_s:.3} s; that time is repeated")
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
        restarts.take_time(1, 2.0);
        restarts.take_time(2, 1.25);
        let task = Process::Task;
        let new = restarts.update(&[(physics, Some(&two)), (task, Some(&one))], 4.0);
        let said = |resumed_s| new[0].line(resumed_s).unwrap();
        assert_eq!((new[0].down_s, new.len()), (2.0, 1));
        let back = "stepped back 0.75 s, to 1.250 s; that time is repeated";
        assert_eq!(
            said(1.25),
            format!("[cell] physics restarted: start 2, {back}")
        );
        assert!(said(2.0).ends_with(", resumed at 2.000 s"), "{}", said(2.0));
        assert!(said(0.0).ends_with(", from the beginning: no saved state"));
        let both = [(physics, Some(&two)), (task, Some(&two))];
        // The task writes its own line.
        assert_eq!(restarts.update(&both, 5.0)[0].line(5.0), None);
        let new = restarts.update(&[(Process::Monitor, Some(&two))], 6.0);
        let line = Some("[cell] monitor restarted: start 2".to_owned());
        assert_eq!(new[0].line(6.0), line);
    }
}
