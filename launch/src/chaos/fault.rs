//! What is done to a running cell.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use cell_rt::clock::monotonic_ns;
use cell_rt::process::{SIGCONT, SIGKILL, SIGSTOP, kill};
use ipc_types::topic::Process;
use supervisor::run::LiveCell;

use super::random::Random;
use crate::cli::ProcessName;
use crate::cli_kinds::FaultKind;

/// Busy loops beside the cell.
const BUSY_LOOPS: usize = 8;
/// How long a busy machine, a full disk and a flood last (ns).
const EPISODE_NS: u64 = 3_000_000_000;
/// Shortest and longest time a process is stopped (ns).
const STOPPED_NS: (f64, f64) = (5.0e7, 2.5e9);
/// Connections of a flood that are open at a time.
const FLOOD: usize = 64;
/// A file system with more room than this is not filled: its memory is the machine's.
const MOST_FILLED: u64 = 512 << 20;
/// Bytes that are overwritten in a file.
const FLIPPED: usize = 64;

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
    /// What is killed and stopped; any process without it.
    only: Option<ProcessName>,
    stopped: Vec<(u64, u32)>,
    busy: Vec<(u64, Child)>,
    filled: Option<(u64, PathBuf)>,
}

impl Faults {
    /// None so far; `only` this process is killed and stopped.
    pub(super) fn new(only: Option<ProcessName>) -> Self {
        let mut this = Self::default();
        this.only = only;
        this
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
                kill(pid, SIGSTOP).ok()?;
                let for_ns = STOPPED_NS.0 + random.share() * (STOPPED_NS.1 - STOPPED_NS.0);
                self.stopped.push((now_ns + nanos(for_ns), pid));
                Some(Begun::Gone(struck))
            }
            FaultKind::Starve => {
                let until_ns = now_ns + EPISODE_NS;
                let loops = (0..BUSY_LOOPS).filter_map(|_| busy_loop().ok());
                self.busy.extend(loops.map(|child| (until_ns, child)));
                Some(Begun::Lasts)
            }
            FaultKind::Flood => {
                let socket = live.run_dir().control();
                let until_ns = now_ns + EPISODE_NS;
                // On a thread of its own: the socket it floods is served by this one.
                let thread = std::thread::Builder::new().name("flood".to_owned());
                thread.spawn(move || flood(&socket, until_ns)).ok()?;
                Some(Begun::Lasts)
            }
            FaultKind::Fill => {
                let path = live.run_dir().path().join("chaos.fill");
                fill(&path)?;
                self.filled = Some((now_ns + EPISODE_NS, path));
                Some(Begun::Lasts)
            }
            FaultKind::Corrupt => {
                let (file, process) = [
                    ("task.slots", Process::Task),
                    ("task.history", Process::Task),
                    ("physics.state", Process::Physics),
                ][random.below(3)];
                corrupt(&live.run_dir().path().join(file), random)?;
                let (struck, pid) = of(live, process, now_ns)?;
                kill(pid, SIGKILL).ok()?;
                Some(Begun::Gone(struck))
            }
        }
    }

    /// Ends what is over, continues what is not.
    pub(super) fn turn(&mut self, live: &LiveCell, now_ns: u64) {
        self.stopped.retain(|(until_ns, pid)| {
            let is_over = now_ns >= *until_ns;
            let runs = live.pids().iter().any(|(_, alive)| *alive == Some(*pid));
            if is_over && runs {
                // It may have been replaced a moment ago.
                kill(*pid, SIGCONT).ok();
            }
            runs && !is_over
        });
        self.busy.retain_mut(|(until_ns, child)| {
            let is_over = now_ns >= *until_ns;
            if is_over {
                end(child);
            }
            !is_over
        });
        if let Some((_, path)) = self.filled.take_if(|(until_ns, _)| now_ns >= *until_ns) {
            std::fs::remove_file(path).ok();
        }
    }
}

impl Drop for Faults {
    fn drop(&mut self) {
        for (_, child) in &mut self.busy {
            end(child);
        }
        if let Some((_, path)) = &self.filled {
            std::fs::remove_file(path).ok();
        }
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
        let Ok(mut stream) = UnixStream::connect(socket) else {
            break;
        };
        if number.is_multiple_of(2) {
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

/// The kernel ends it after 10 s of processor time, if the launcher does not.
fn busy_loop() -> std::io::Result<Child> {
    Command::new("sh")
        .args(["-c", "ulimit -t 10; while :; do :; done"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
}

fn end(child: &mut Child) {
    child.kill().ok();
    child.wait().ok();
}

fn fill(path: &Path) -> Option<()> {
    let dir = path.parent()?;
    let free = cell_rt::memory::free_bytes(dir).ok()?;
    if free > MOST_FILLED {
        return None;
    }
    let mut file = File::create(path).ok()?;
    let zeros = vec![0; 1 << 16];
    // Until nothing is left; the error is what is wanted.
    while file.write_all(&zeros).is_ok() {}
    Some(())
}

fn corrupt(path: &Path, random: &mut Random) -> Option<()> {
    let mut file = File::options().read(true).write(true).open(path).ok()?;
    let length = usize::try_from(file.metadata().ok()?.len()).ok()?;
    for _ in 0..FLIPPED {
        let at = SeekFrom::Start(random.below(length) as u64);
        let mut byte = [0];
        file.seek(at).ok()?;
        file.read_exact(&mut byte).ok()?;
        file.seek(at).ok()?;
        file.write_all(&[!byte[0]]).ok()?;
    }
    Some(())
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between the bounds above"
)]
fn nanos(ns: f64) -> u64 {
    ns as u64
}
