//! Causes of missed cycles, derived from the health of the processes.

use ipc_types::topic::Process;
use ipc_types::{Health, TICK_NS};

/// Health has figures of whole seconds: those of the second of a missed cycle are published at
/// most this long after it (ns).
// A second, one status of 250 ms later.
const KNOWN_AFTER_NS: u64 = 1_250_000_000;
/// An arm's controller that starts late is not the cause if physics started at least this share
/// of the delay late.
// Half, as both delays are the longest of a second and need not be of one cycle.
const SHARE_OF_PHYSICS: f64 = 0.5;

/// Follows the counts of missed cycles.
#[derive(Clone, Debug, Default)]
pub struct MissedCycles {
    counted: Vec<Counted>,
}

/// Last state of one process.
#[derive(Clone, Debug)]
struct Counted {
    process: Process,
    pid: u32,
    missed: u64,
    /// The newest missed cycles.
    newest: Option<LastMisses>,
}

#[derive(Clone, Debug)]
struct LastMisses {
    count: u64,
    time_s: f64,
    open_until_ns: u64,
    late_ns: f64,
    body_ns: f64,
    physics_late_ns: f64,
}

impl MissedCycles {
    /// Cause of the last missed cycles of each of `processes`, in their order; empty if it
    /// missed none since it was first seen. `time_s` is simulated.
    pub fn update(
        &mut self,
        processes: &[(Process, Option<&Health>)],
        time_s: f64,
        now_ns: u64,
    ) -> Vec<String> {
        let physics = processes.iter().find(|(p, _)| *p == Process::Physics);
        let physics_late_ns = physics
            .and_then(|(_, health)| *health)
            .map_or(0.0, |health| health.lateness_max_ns);
        let one = |(process, health): &(Process, Option<&Health>)| {
            let Some(health) = health else {
                return String::new();
            };
            // Physics cannot be late because of physics.
            let late_ns = match process {
                Process::Physics => 0.0,
                _ => physics_late_ns,
            };
            self.one(*process, health, late_ns, time_s, now_ns)
        };
        processes.iter().map(one).collect()
    }

    fn one(
        &mut self,
        process: Process,
        health: &Health,
        physics_late_ns: f64,
        time_s: f64,
        now_ns: u64,
    ) -> String {
        let missed = health.missed_cycles;
        // Cycles missed before the first look have no time that could be shown.
        let Some(counted) = self
            .counted
            .iter_mut()
            .find(|counted| counted.process == process)
        else {
            self.counted.push(Counted {
                process,
                pid: health.pid,
                missed,
                newest: None,
            });
            return String::new();
        };
        if counted.pid != health.pid {
            // Another process counts from 0.
            (counted.pid, counted.missed) = (health.pid, missed);
        }
        let more = missed.saturating_sub(counted.missed);
        counted.missed = missed;
        if more > 0 {
            // Misses within one window are one event: its figures cannot be separated.
            let open = counted.newest.take().filter(|n| now_ns < n.open_until_ns);
            let newest = open.unwrap_or(LastMisses {
                count: 0,
                time_s,
                open_until_ns: 0,
                late_ns: 0.0,
                body_ns: 0.0,
                physics_late_ns: 0.0,
            });
            counted.newest = Some(LastMisses {
                count: newest.count + more,
                open_until_ns: now_ns + KNOWN_AFTER_NS,
                ..newest
            });
        }
        let Some(newest) = &mut counted.newest else {
            return String::new();
        };
        // The largest figures while they can still be of the missed cycles.
        if now_ns < newest.open_until_ns {
            newest.late_ns = newest.late_ns.max(health.lateness_max_ns);
            newest.body_ns = newest.body_ns.max(health.body_p99_ns);
            newest.physics_late_ns = newest.physics_late_ns.max(physics_late_ns);
        }
        newest.text()
    }
}

impl LastMisses {
    fn text(&self) -> String {
        let period_ns = TICK_NS as f64;
        let ms = |ns: f64| ns * 1.0e-6;
        // Own work first: it explains the delay regardless of the others.
        let why = if self.body_ns >= period_ns {
            format!("a cycle took {:.1} ms", ms(self.body_ns))
        } else if self.physics_late_ns >= (SHARE_OF_PHYSICS * self.late_ns).max(period_ns) {
            format!("physics started {:.1} ms late", ms(self.physics_late_ns))
        } else if self.late_ns >= period_ns {
            format!("it was given the processor {:.1} ms late", ms(self.late_ns))
        } else {
            "no new state arrived in time".to_owned()
        };
        format!("the last {} at {:.1} s: {why}", self.count, self.time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    const S: u64 = 1_000_000_000;

    fn health(missed: u64, late_ms: f64, body_ms: f64) -> Health {
        let mut health = Health::zeroed();
        health.pid = 7;
        health.missed_cycles = missed;
        health.lateness_max_ns = late_ms * 1.0e6;
        health.body_p99_ns = body_ms * 1.0e6;
        health
    }

    #[test]
    fn each_cause_is_told_apart_once_its_second_is_over() {
        let cases = [
            (
                (3, 4.2, 0.2),
                (0, 0.1, 0.2),
                "the last 3 at 2.0 s: it was given the processor 4.2 ms late",
            ),
            (
                (1, 4.2, 3.0),
                (0, 9.0, 0.2),
                "the last 1 at 2.0 s: a cycle took 3.0 ms",
            ),
            (
                (2, 4.2, 0.2),
                (2, 4.0, 0.2),
                "the last 2 at 2.0 s: physics started 4.0 ms late",
            ),
            (
                (2, 0.1, 0.2),
                (0, 0.1, 0.2),
                "the last 2 at 2.0 s: no new state arrived in time",
            ),
        ];
        for ((missed, late, body), (more, physics_late, physics_body), cause) in cases {
            let mut misses = MissedCycles::default();
            let mut update = |controller: Health, physics: Health, time_s, now_ns| {
                let all = [
                    (Process::Physics, Some(&physics)),
                    (Process::Controller(0), Some(&controller)),
                ];
                misses.update(&all, time_s, now_ns)[1].clone()
            };
            // Cycles missed before the first look have no time.
            let calm = |missed| health(missed, 0.05, 0.2);
            assert_eq!(update(calm(5), calm(5), 1.0, S), "");
            update(calm(5 + missed), calm(5 + more), 2.0, 2 * S);
            let worst = (
                health(5 + missed, late, body),
                health(5 + more, physics_late, physics_body),
            );
            assert_eq!(update(worst.0, worst.1, 3.0, 3 * S), cause);
            // Later seconds do not change the cause.
            let other = (health(5 + missed, 50.0, 50.0), calm(5 + more));
            assert_eq!(update(other.0, other.1, 9.0, 9 * S), cause);
        }
    }

    #[test]
    fn a_new_process_counts_anew() {
        let mut misses = MissedCycles::default();
        let mut update = |pid, missed| {
            let mut one = health(missed, 9.0, 0.1);
            one.pid = pid;
            misses.update(&[(Process::Physics, Some(&one))], 1.0, S)[0].clone()
        };
        assert_eq!(update(1, 100), "");
        assert_eq!(update(2, 3), "");
        assert!(update(2, 4).starts_with("the last 1 at"));
    }
}
