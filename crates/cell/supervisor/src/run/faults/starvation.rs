//! Which processes get no core, or are about to be gone: they do not hang.
//!
//! A process that is silent has to answer for its silence, except for the time in which
//! it could do nothing (docs/faults.md). That time has four sources, and a change must
//! keep each of them:
//!
//! - The kernel counts how long its main thread waited for a core.
//! - A main thread that waits now, for a core or within the kernel for a disk or a page,
//!   has waited since the last look but for the time it ran. Delay accounting of the kernel
//!   would count the disk, and is off by default.
//! - A main thread that sleeps may wait for a lock of another thread of the process, which
//!   is of the normal class and starves: then what that thread could not do counts. So does
//!   one that was asked to end and waits for its threads, such as the recorder, which writes
//!   the index of its file.
//! - Time in which this thread did not look does not count against any process. The run
//!   directory on a slow disk holds the launcher and physics at once: when both work again,
//!   the process sleeps until its next cycle, and its sign of life is a few milliseconds away.

use cell_rt::process::Share;
use cell_run::incident::STARVED;
use ipc_types::topic::Process;

use crate::run::machine::Threads;
use crate::supervision::Event;

/// A process that has been silent for this long is looked at in every turn (ns).
const SILENT_NS: u64 = 20_000_000;
/// Time between two looks at the other processes (ns).
const PERIOD_NS: u64 = 50_000_000;
/// Of the time between two turns so much counts as looked at (ns); it is 5 ms where the
/// launcher is not delayed.
const MAX_GAP_NS: u64 = 20_000_000;

/// A process that exists.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Running {
    pub(crate) process: Process,
    pub(crate) generation: u32,
    pub(crate) pid: u32,
    /// For how long it has given no sign of life (ns).
    pub(crate) silence_ns: u64,
    /// Whether it was asked to end.
    pub(crate) leaves: bool,
}

/// What the kernel said of each process at the last look.
#[derive(Debug, Default)]
pub(crate) struct Starvation {
    /// By thread.
    last: Vec<(u32, Share)>,
    looked_ns: u64,
    turned_ns: Option<u64>,
}

impl Starvation {
    /// Time each of `running` could not run since the last look, and which of them ends,
    /// as events; `threads` says what the kernel says of a process.
    pub(crate) fn look(
        &mut self,
        now_ns: u64,
        running: &[Running],
        threads: impl Fn(u32, bool) -> Option<Threads>,
    ) -> Vec<Event> {
        let gap_ns = now_ns.saturating_sub(self.turned_ns.replace(now_ns).unwrap_or(now_ns));
        let unseen_ns = gap_ns.saturating_sub(MAX_GAP_NS);
        let elapsed_ns = now_ns.saturating_sub(self.looked_ns);
        let is_silent = |one: &Running| one.leaves || one.silence_ns >= SILENT_NS;
        if unseen_ns == 0 && elapsed_ns < PERIOD_NS && !running.iter().any(is_silent) {
            return Vec::new();
        }
        self.looked_ns = now_ns;
        let mut events = Vec::new();
        let mut shares = Vec::new();
        for one in running {
            let (process, generation) = (one.process, one.generation);
            let Some((main, others)) = threads(one.pid, is_silent(one)) else {
                continue;
            };
            if main.ended {
                events.push(Event::Dying {
                    process,
                    generation,
                });
            }
            let starved = |(id, share): &(u32, Share)| {
                let before = self.last.iter().find(|(before, _)| before == id)?;
                Some(share.starved_ns(&before.1, elapsed_ns))
            };
            let of_main = starved(&(one.pid, main)).unwrap_or(0);
            let of_others = others.iter().filter(|_| main.sleeps).filter_map(starved);
            let ns = of_others.fold(of_main, u64::max).max(unseen_ns);
            if ns > 0 {
                events.push(Event::Starved {
                    process,
                    generation,
                    ns,
                });
            }
            shares.push((one.pid, main));
            shares.extend(others);
        }
        self.last = shares;
        events
    }
}

/// What a person is told.
pub(crate) fn report(process: Process, starved_ns: u64, silent_ns: u64) -> String {
    const MS: u64 = 1_000_000;
    format!(
        "{} {STARVED}, or waits for a disk or for memory: it could not run \
         for {} of the last {} ms. It is left running; an arm without fresh setpoints holds. Close \
         other programs, keep the run directory in memory, or allow real-time scheduling \
         (`robocell doctor` says how)",
        process.name(),
        starved_ns / MS,
        silent_ns / MS
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;
    const PHYSICS: u32 = 7;
    const WRITER: u32 = 8;

    /// Sleeps, and has never run.
    fn asleep() -> Share {
        Share {
            sleeps: true,
            ..Share::default()
        }
    }

    /// Waits for a core or a disk.
    fn waiting() -> Share {
        Share {
            waits: true,
            ..Share::default()
        }
    }

    fn silent(silence_ms: u64) -> [Running; 1] {
        [Running {
            process: Process::Physics,
            generation: 1,
            pid: PHYSICS,
            silence_ns: silence_ms * MS,
            leaves: false,
        }]
    }

    /// Milliseconds that count as starved at a look.
    fn look(starvation: &mut Starvation, at_ms: u64, silence_ms: u64, threads: &Threads) -> u64 {
        let seen = |_: u32, all: bool| {
            let others = threads.1.iter().filter(|_| all).copied();
            Some((threads.0, others.collect()))
        };
        let events = starvation.look(at_ms * MS, &silent(silence_ms), seen);
        let starved = |event: &Event| match event {
            Event::Starved { ns, .. } => ns / MS,
            _ => 0,
        };
        events.iter().map(starved).sum()
    }

    #[test]
    fn a_process_that_waits_for_a_disk_is_starved_for_as_long_as_it_does() {
        let mut starvation = Starvation::default();
        let turns = (0..30).map(|turn| 1000 + 5 * turn);
        let of = |starvation: &mut Starvation, thread: Share| -> u64 {
            let looks = turns.clone().map(|at| (at, at - 1000));
            let threads = (thread, vec![]);
            looks
                .map(|(at, ms)| look(starvation, at, ms, &threads))
                .sum()
        };
        assert!(of(&mut starvation, waiting()) >= 140);
        assert_eq!(of(&mut Starvation::default(), asleep()), 0, "it hangs");
    }

    #[test]
    fn a_launcher_that_did_not_look_accuses_nobody_of_what_it_did_not_see() {
        let mut starvation = Starvation::default();
        let threads = (asleep(), vec![]);
        assert_eq!(look(&mut starvation, 1000, 0, &threads), 0);
        // A disk held both; the process sleeps until its next cycle.
        assert_eq!(look(&mut starvation, 1103, 103, &threads), 83);
        assert_eq!(look(&mut starvation, 1108, 108, &threads), 0);
    }

    #[test]
    fn a_process_that_sleeps_is_starved_while_another_thread_of_it_is() {
        let mut starvation = Starvation::default();
        let (locked, works) = (
            (asleep(), vec![(WRITER, waiting())]),
            Share {
                ran_ns: 5 * MS,
                ..Share::default()
            },
        );
        look(&mut starvation, 1000, 20, &locked);
        assert_eq!(look(&mut starvation, 1005, 25, &locked), 5);
        // A main thread that runs does not wait for the other.
        let runs = (works, vec![(WRITER, waiting())]);
        assert_eq!(look(&mut starvation, 1010, 30, &runs), 0);
        // No thread of it waits: it hangs.
        let hangs = (asleep(), vec![(WRITER, asleep())]);
        look(&mut starvation, 1015, 35, &hangs);
        assert_eq!(look(&mut starvation, 1020, 40, &hangs), 0);
    }

    #[test]
    fn a_process_that_ends_is_starved_while_a_thread_that_it_waits_for_is() {
        let mut starvation = Starvation::default();
        // Its main thread waits for the recorder; it answers for no silence any more.
        let leaving = [Running {
            leaves: true,
            ..silent(0)[0]
        }];
        let seen = |_: u32, all: bool| {
            let recorder = all.then_some((WRITER, waiting()));
            Some((asleep(), recorder.into_iter().collect()))
        };
        let mut starved_ns = 0;
        for turn in 0..200 {
            for event in starvation.look((1000 + 5 * turn) * MS, &leaving, seen) {
                if let Event::Starved { ns, .. } = event {
                    starved_ns += ns;
                }
            }
        }
        // All of the second but for the first look.
        assert!(starved_ns >= 990 * MS, "{starved_ns}");
    }
}
