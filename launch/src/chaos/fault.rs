//! Faults of a running cell.

use std::collections::VecDeque;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::path::Path;

use cell_model::cells::script::{CORRUPTIBLE, ScriptAction};
use cell_model::random::Random;
use cell_rt::clock::monotonic_ns;
use cell_rt::process::{SIGCONT, SIGKILL, SIGSTOP, kill};
use ipc_types::topic::Process;
use supervisor::run::{Disturbances, LiveCell};

use crate::args::ProcessName;
use crate::args::kinds::FaultKind;

/// How long a busy machine, a full disk and a flood last (s).
const EPISODE_S: f64 = 3.0;
/// Shortest and longest time a process is stopped (ns).
// The watchdog replaces a process after 0.1 to 2 s: stops end before and after that.
const STOPPED_NS: (f64, f64) = (5.0e7, 2.5e9);
/// Connections of a flood that are open at a time.
// As many as the control socket serves at a time: each further one displaces the oldest.
const FLOOD: usize = 64;

/// A process that has to come back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Struck {
    pub(super) process: Process,
    pub(super) generation: u32,
    pub(super) since_ns: u64,
}

/// What a fault does.
#[derive(Clone, Copy, Debug)]
pub(super) enum Begun {
    /// A process has to come back.
    Gone(Struck),
    /// The cell has to live with it.
    Lasts,
}

/// Faults that last.
#[derive(Debug, Default)]
pub(super) struct Faults {
    /// The process that is killed and stopped; any process if `None`.
    only: Option<ProcessName>,
    stopped: Vec<(u64, u32)>,
    disturbances: Disturbances,
}

impl Faults {
    /// None so far; `only` this process is killed and stopped.
    pub(super) fn new(only: Option<ProcessName>) -> Self {
        Self {
            only,
            ..Self::default()
        }
    }

    /// Does `kind` to the cell; `None` where it cannot be done now.
    pub(super) fn begin(
        &mut self,
        kind: FaultKind,
        live: &LiveCell,
        random: &mut Random,
        now_ns: u64,
    ) -> Option<Begun> {
        match kind {
            FaultKind::Kill => kill_one(live, self.only, random, now_ns).map(Begun::Gone),
            FaultKind::Stop => {
                let (struck, pid) = victim(live, self.only, random, now_ns)?;
                // A process that has just ended cannot be stopped: this fault is not counted.
                kill(pid, SIGSTOP).ok()?;
                let for_ns = STOPPED_NS.0 + random.share() * (STOPPED_NS.1 - STOPPED_NS.0);
                self.stopped.push((now_ns + nanos(for_ns), pid));
                Some(Begun::Gone(struck))
            }
            FaultKind::Starve => {
                let action = ScriptAction::Starve { for_s: EPISODE_S };
                self.disturb(live, now_ns, &action)
            }
            FaultKind::Flood => {
                let socket = live.run_dir().control();
                let until_ns = now_ns + nanos(1.0e9 * EPISODE_S);
                // On a thread of its own: the socket it floods is served by this one.
                let thread = std::thread::Builder::new().name("flood".to_owned());
                thread.spawn(move || flood(&socket, until_ns)).ok()?;
                Some(Begun::Lasts)
            }
            FaultKind::Fill => {
                let action = ScriptAction::Fill { for_s: EPISODE_S };
                self.disturb(live, now_ns, &action)
            }
            FaultKind::Corrupt => {
                let file = CORRUPTIBLE[random.below(CORRUPTIBLE.len())].to_owned();
                let is_task = file.starts_with("task");
                let process = if is_task {
                    Process::Task
                } else {
                    Process::Physics
                };
                // Before the kill: the successor reads the file some milliseconds after it.
                self.disturb(live, now_ns, &ScriptAction::Corrupt { file })?;
                let (struck, pid) = of(live, process, now_ns)?;
                kill(pid, SIGKILL).ok()?;
                Some(Begun::Gone(struck))
            }
        }
    }

    /// Ends the faults whose time has passed.
    pub(super) fn turn(&mut self, live: &LiveCell, now_ns: u64) {
        self.stopped.retain(|(until_ns, pid)| {
            let is_over = now_ns >= *until_ns;
            // A pid that is no longer of the cell may belong to another program by now.
            let runs = live.pids().iter().any(|(_, alive)| *alive == Some(*pid));
            if is_over && runs {
                // It may have been replaced a moment ago.
                kill(*pid, SIGCONT).ok();
            }
            runs && !is_over
        });
        self.disturbances.turn(now_ns);
    }

    fn disturb(&mut self, live: &LiveCell, now_ns: u64, action: &ScriptAction) -> Option<Begun> {
        let run_dir = live.run_dir().path();
        let begun = self.disturbances.begin(run_dir, now_ns, action);
        begun.ok().map(|()| Begun::Lasts)
    }
}

/// Connects as fast as it can; every other connection talks nonsense, the others say
/// nothing.
fn flood(socket: &Path, until_ns: u64) {
    let mut open = VecDeque::new();
    for number in 0_u64.. {
        if monotonic_ns() >= until_ns {
            break;
        }
        // The launcher removes the socket when the cell ends, perhaps before the flood does.
        let Ok(mut stream) = UnixStream::connect(socket) else {
            break;
        };
        if number.is_multiple_of(2) {
            // The launcher may have closed the connection already: it serves a limited number.
            stream.write_all(b"{\"ask\": [[[[\n").ok();
        }
        open.push_back(stream);
        if open.len() > FLOOD {
            open.pop_front();
        }
    }
}

/// Kills a process; `None` where it is gone already.
pub(super) fn kill_one(
    live: &LiveCell,
    only: Option<ProcessName>,
    random: &mut Random,
    now_ns: u64,
) -> Option<Struck> {
    let (struck, pid) = victim(live, only, random, now_ns)?;
    kill(pid, SIGKILL).ok()?;
    Some(struck)
}

fn victim(
    live: &LiveCell,
    only: Option<ProcessName>,
    random: &mut Random,
    now_ns: u64,
) -> Option<(Struck, u32)> {
    let mut pids = live.pids();
    pids.retain(|(process, _)| only.is_none_or(|name| name.includes(*process)));
    let (process, _) = pids.get(random.below(pids.len()))?;
    of(live, *process, now_ns)
}

fn of(live: &LiveCell, process: Process, now_ns: u64) -> Option<(Struck, u32)> {
    let mut pids = live.pids().into_iter();
    let pid = pids.find(|(other, _)| *other == process)?.1?;
    let struck = Struck {
        process,
        generation: live.generation(process),
        since_ns: now_ns,
    };
    Some((struck, pid))
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between the bounds above"
)]
fn nanos(ns: f64) -> u64 {
    ns as u64
}
