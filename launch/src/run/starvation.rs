//! Which processes get no core, or are about to be gone: they do not hang.

use cell_rt::process::Share;
use ipc_types::topic::Process;

use crate::supervisor::Event;

/// A process that has been silent for this long is looked at in every turn (ns).
const SILENT_NS: u64 = 20_000_000;
/// Otherwise so much time lies between two looks (ns).
const PERIOD_NS: u64 = 50_000_000;

/// What the kernel said of each process at the last look.
#[derive(Debug, Default)]
pub(super) struct Starvation {
    last: Vec<(u32, Share)>,
    looked_ns: u64,
}

impl Starvation {
    /// Time each of `running` (with generation and pid) could not run since the last
    /// look, and which of them ends, as events.
    pub(super) fn poll(
        &mut self,
        now_ns: u64,
        silence_ns: u64,
        running: &[(Process, u32, u32)],
    ) -> Vec<Event> {
        let elapsed_ns = now_ns.saturating_sub(self.looked_ns);
        if silence_ns < SILENT_NS && elapsed_ns < PERIOD_NS {
            return Vec::new();
        }
        self.looked_ns = now_ns;
        let mut events = Vec::new();
        let mut shares = Vec::new();
        for (process, generation, pid) in running {
            let Some(share) = Share::of(*pid) else {
                continue;
            };
            shares.push((*pid, share));
            if share.ended {
                events.push(Event::Dying {
                    process: *process,
                    generation: *generation,
                });
            }
            let before = self.last.iter().find(|(before, _)| before == pid);
            let ns = before.map_or(0, |(_, before)| share.starved_ns(before, elapsed_ns));
            if ns > 0 {
                events.push(Event::Starved {
                    process: *process,
                    generation: *generation,
                    ns,
                });
            }
        }
        self.last = shares;
        events
    }
}

/// What a person is told.
pub(super) fn report(process: Process, starved_ns: u64, silent_ns: u64) -> String {
    const MS: u64 = 1_000_000;
    format!(
        "{} gets too little processor time: it could not run for {} of the last {} ms. It is left \
         running; an arm without fresh setpoints holds. Close other programs, or allow real-time \
         scheduling (`robocell doctor` says how)",
        process.name(),
        starved_ns / MS,
        silent_ns / MS
    )
}
