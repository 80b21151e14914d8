//! One process under supervision.

use std::collections::VecDeque;

use ipc_types::topic::Process;

use super::{Action, Exit, MS, Rules};

/// A process shows its first health message within this.
const READY_DEADLINE: u64 = 2_000 * MS;
/// It is left alone for this long after its start: a signal during start-up
/// can leave a slot of the shared memory taken for ever.
const MIN_RUN: u64 = 50 * MS;
/// Between SIGTERM and SIGKILL.
const STOP_GRACE: u64 = 1_000 * MS;
/// A process that ran for longer than this is started again at once.
const LONG_LIFE: u64 = 1_000 * MS;
/// First delay before a restart; doubles with each short life.
const BACKOFF_FIRST: u64 = 50 * MS;
/// Longest delay before a restart.
const BACKOFF_MAX: u64 = 2_000 * MS;
/// More crashes than this within the window, and it is given up.
const MAX_CRASHES: usize = 5;
/// So many starts in a row without a sign of life, and it is given up: they
/// take too long to fill the window.
const MAX_HUNG_STARTS: u32 = 3;
/// The window crashes are counted in.
const CRASH_WINDOW: u64 = 10_000 * MS;
/// Time between two polls counts at most this much towards a hang, so that a
/// launcher that was not scheduled accuses nobody.
const MAX_POLL_GAP: u64 = 20 * MS;
/// Hang limit while physics waits for everybody.
const HANG_LOCKSTEP: u64 = 5_000 * MS;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lifecycle {
    /// Never started.
    NotStarted,
    /// Started, no health message yet.
    Starting,
    /// Shows itself.
    Up,
    /// SIGTERM sent at that time, to be started again.
    Leaving(u64),
    /// SIGKILL sent.
    Killed,
    /// Comes back at that time.
    Waiting(u64),
    /// Gone for good.
    Down,
}

#[derive(Debug)]
pub(super) struct Slot {
    pub(super) process: Process,
    pub(super) state: Lifecycle,
    pub(super) generation: u32,
    spawned_at: u64,
    crashes: VecDeque<u64>,
    hung_starts: u32,
    /// Lives shorter than [`LONG_LIFE`] in a row.
    short_lives: u32,
    /// The next exit was asked for and counts as no crash.
    commanded: bool,
    /// A restart was asked for: `Some(gently)`.
    wanted: Option<bool>,
    fifo: bool,
    cycles: u64,
    frozen_ns: u64,
    polled_at: u64,
}

impl Slot {
    pub(super) fn new(process: Process) -> Self {
        Self {
            process,
            state: Lifecycle::NotStarted,
            generation: 0,
            spawned_at: 0,
            crashes: VecDeque::new(),
            hung_starts: 0,
            short_lives: 0,
            commanded: false,
            wanted: None,
            fifo: false,
            cycles: 0,
            frozen_ns: 0,
            polled_at: 0,
        }
    }

    /// Whether a process exists.
    pub(super) fn runs(&self) -> bool {
        matches!(
            self.state,
            Lifecycle::Starting | Lifecycle::Up | Lifecycle::Leaving(_) | Lifecycle::Killed
        )
    }

    pub(super) fn alive(&mut self, cycles: u64, fifo: bool) {
        if self.state == Lifecycle::Starting {
            self.state = Lifecycle::Up;
            self.frozen_ns = 0;
            self.hung_starts = 0;
        }
        self.fifo = fifo;
        // Task and monitor have no cycle while nothing new arrives, such as in
        // a pause; their message comes from the same loop and shows they live.
        let may_wait = matches!(self.process, Process::Task | Process::Monitor);
        if cycles != self.cycles || may_wait {
            self.cycles = cycles;
            self.frozen_ns = 0;
        }
    }

    pub(super) fn ask_restart(&mut self, now: u64, gently: bool) {
        match self.state {
            Lifecycle::Starting | Lifecycle::Up => self.wanted = Some(gently),
            Lifecycle::Waiting(_) => self.state = Lifecycle::Waiting(now),
            Lifecycle::NotStarted | Lifecycle::Leaving(_) | Lifecycle::Killed | Lifecycle::Down => {
            }
        }
    }

    /// A process that does not exist now will not exist later.
    pub(super) fn forget_plans(&mut self) {
        self.wanted = None;
        if matches!(self.state, Lifecycle::NotStarted | Lifecycle::Waiting(_)) {
            self.state = Lifecycle::Down;
        }
    }

    pub(super) fn exited(&mut self, now: u64, exit: Exit, out: &mut Vec<Action>) {
        let process = self.process;
        let hung = self.state == Lifecycle::Killed;
        self.wanted = None;
        if self.commanded {
            self.commanded = false;
            self.state = Lifecycle::Waiting(now);
            return;
        }
        if let Some(reason) = self.verdict(now, exit) {
            self.state = Lifecycle::Down;
            out.push(Action::GaveUp { process, reason });
            return;
        }
        self.state = Lifecycle::Waiting(now.max(self.spawned_at + MIN_RUN) + self.backoff());
        if !hung {
            out.push(Action::Lost {
                process,
                what: describe(exit),
            });
        }
    }

    /// Why another start would be useless, if it would.
    fn verdict(&mut self, now: u64, exit: Exit) -> Option<String> {
        if let Exit::Code(2 | 3) = exit {
            return Some(format!("it {}", describe(exit)));
        }
        if self.hung_starts >= MAX_HUNG_STARTS {
            return Some(format!(
                "{MAX_HUNG_STARTS} starts in a row gave no sign of life within 2 s"
            ));
        }
        self.crashes.push_back(now);
        let is_short = now.saturating_sub(self.spawned_at) < LONG_LIFE;
        self.short_lives = if is_short { self.short_lives + 1 } else { 0 };
        while self
            .crashes
            .front()
            .is_some_and(|t| now.saturating_sub(*t) > CRASH_WINDOW)
        {
            self.crashes.pop_front();
        }
        let count = self.crashes.len();
        (count > MAX_CRASHES).then(|| {
            format!(
                "it ended {count} times within 10 s; the last time it {}",
                describe(exit)
            )
        })
    }

    /// The first short life is answered at once, the following with a delay.
    fn backoff(&self) -> u64 {
        match self.short_lives {
            0 | 1 => 0,
            n => BACKOFF_MAX.min(BACKOFF_FIRST << (n - 2).min(10)),
        }
    }

    pub(super) fn keep(&mut self, now: u64, rules: Rules, may_start: bool, out: &mut Vec<Action>) {
        let gap = now.saturating_sub(self.polled_at).min(MAX_POLL_GAP);
        self.polled_at = now;
        match self.state {
            Lifecycle::NotStarted if may_start => self.spawn(now, out),
            Lifecycle::Waiting(until) if now >= until => self.spawn(now, out),
            Lifecycle::Leaving(since) if now >= since + STOP_GRACE => self.kill(out),
            Lifecycle::Starting | Lifecycle::Up => {
                self.frozen_ns += gap;
                self.watch(now, rules, out);
            }
            _ => {}
        }
    }

    fn spawn(&mut self, now: u64, out: &mut Vec<Action>) {
        self.generation += 1;
        self.state = Lifecycle::Starting;
        self.spawned_at = now;
        self.cycles = 0;
        self.frozen_ns = 0;
        out.push(Action::Spawn {
            process: self.process,
            generation: self.generation,
        });
    }

    fn watch(&mut self, now: u64, rules: Rules, out: &mut Vec<Action>) {
        let age = now.saturating_sub(self.spawned_at);
        if let Some(gently) = self.wanted
            && age >= MIN_RUN
        {
            self.wanted = None;
            self.commanded = true;
            if gently {
                self.state = Lifecycle::Leaving(now);
                out.push(Action::Terminate {
                    process: self.process,
                });
            } else {
                self.kill(out);
            }
            return;
        }
        if !rules.watchdog {
            return;
        }
        let what = match self.state {
            Lifecycle::Starting if self.frozen_ns >= READY_DEADLINE => {
                self.hung_starts += 1;
                "gave no sign of life within 2 s of its start".to_owned()
            }
            Lifecycle::Up if self.frozen_ns >= self.hang_limit(rules) => {
                format!("hangs: no new cycle for {} ms", self.frozen_ns / MS)
            }
            _ => return,
        };
        out.push(Action::Lost {
            process: self.process,
            what,
        });
        self.kill(out);
    }

    fn kill(&mut self, out: &mut Vec<Action>) {
        self.state = Lifecycle::Killed;
        out.push(Action::Kill {
            process: self.process,
        });
    }

    /// For how long `cycles` may stand still. Without real-time scheduling a
    /// busy machine alone can hold a process back for longer than 100 ms.
    fn hang_limit(&self, rules: Rules) -> u64 {
        match self.process {
            Process::Monitor => 2_000 * MS,
            _ if rules.lockstep => HANG_LOCKSTEP,
            Process::Physics | Process::Controller(_) if self.fifo => 100 * MS,
            Process::Physics | Process::Controller(_) | Process::Task => 500 * MS,
        }
    }

    /// One step of an orderly stop.
    pub(super) fn stop(&mut self, now: u64, out: &mut Vec<Action>) {
        match self.state {
            Lifecycle::Starting | Lifecycle::Up if now >= self.spawned_at + MIN_RUN => {
                self.state = Lifecycle::Leaving(now);
                out.push(Action::Terminate {
                    process: self.process,
                });
            }
            Lifecycle::Leaving(since) if now >= since + STOP_GRACE => self.kill(out),
            _ => {}
        }
    }
}

/// An exit in words a person can act on.
fn describe(exit: Exit) -> String {
    match exit {
        Exit::Code(0) => "ended without being asked".to_owned(),
        Exit::Code(101) => "panicked (exit code 101)".to_owned(),
        Exit::Code(code) => format!("ended with exit code {code}"),
        Exit::Signal(7) => {
            "was ended by SIGBUS: shared memory is full; free space in /dev/shm".to_owned()
        }
        Exit::Signal(9) => "was killed (SIGKILL)".to_owned(),
        Exit::Signal(11) => "was ended by SIGSEGV".to_owned(),
        Exit::Signal(signal) => format!("was ended by signal {signal}"),
    }
}
