//! The answer to the end of a process: another start, a delay before it, or none.

use cell_rt::process::{SIGBUS, SIGKILL};
use ipc_types::topic::Process;

use super::{Lifecycle, MAX_HUNG_STARTS, MIN_RUN, Slot};
use crate::supervision::{Action, Exit, MS};

/// A process that ran for longer than this is started again at once.
pub(super) const LONG_LIFE: u64 = 1_000 * MS;
/// First delay before a restart; doubles with each short life.
const BACKOFF_FIRST: u64 = 50 * MS;
/// Longest delay before a restart.
const BACKOFF_MAX: u64 = 2_000 * MS;
/// More crashes than this within the window, and it is given up.
const MAX_CRASHES: usize = 5;
/// The window crashes are counted in.
const CRASH_WINDOW: u64 = 10_000 * MS;
/// A monitor that was given up is tried again after this; doubles each time.
const RETRY_FIRST: u64 = 30_000 * MS;
/// Longest delay before a monitor that was given up is tried again.
const RETRY_MAX: u64 = 300_000 * MS;

impl Slot {
    /// It ended while there was no room for its files, which does not count as a crash.
    pub(in crate::supervision) fn ended_without_room(
        &mut self,
        now: u64,
        exit: Exit,
        out: &mut Vec<Action>,
    ) {
        let hung = self.state == Lifecycle::Killed;
        (self.wanted, self.commanded) = (None, false);
        self.state = Lifecycle::Waiting(now);
        if !hung {
            out.push(Action::Lost {
                process: self.process,
                what: describe(exit, false),
            });
        }
    }

    pub(in crate::supervision) fn exited(&mut self, now: u64, exit: Exit, out: &mut Vec<Action>) {
        let process = self.process;
        let hung = self.state == Lifecycle::Killed;
        let worked = self.state == Lifecycle::Up;
        self.wanted = None;
        if self.commanded {
            self.commanded = false;
            self.state = Lifecycle::Waiting(now);
            return;
        }
        // Not reported again: the retries of a monitor may fail for hours.
        if self.is_given_up() {
            self.retry_later(now);
            return;
        }
        if let Some(reason) = self.verdict(now, exit, worked) {
            let refused = exit == Exit::Code(3) && !worked;
            self.end(now, reason, refused, out);
            return;
        }
        self.state = Lifecycle::Waiting(now.max(self.spawned_at + MIN_RUN) + self.backoff());
        // A hang was reported before the process was killed.
        if !hung {
            out.push(Action::Lost {
                process,
                what: describe(exit, true),
            });
        }
    }

    /// Nothing of a cell depends on its monitor, so that one is tried again.
    pub(in crate::supervision) fn give_up(
        &mut self,
        now: u64,
        reason: String,
        out: &mut Vec<Action>,
    ) {
        self.end(now, reason, false, out);
    }

    fn end(&mut self, now: u64, reason: String, refused: bool, out: &mut Vec<Action>) {
        let process = self.process;
        if process == Process::Monitor {
            self.retry_later(now);
        } else {
            self.state = Lifecycle::Down;
        }
        out.push(Action::GaveUp {
            process,
            reason,
            refused,
        });
    }

    fn retry_later(&mut self, now: u64) {
        self.retry = (2 * self.retry).clamp(RETRY_FIRST, RETRY_MAX);
        self.state = Lifecycle::Waiting(now + self.retry);
        self.crashes.clear();
        self.hung_starts = 0;
        self.short_lives = 0;
    }

    /// Why another start would be useless, if it would.
    fn verdict(&mut self, now: u64, exit: Exit, worked: bool) -> Option<String> {
        // Wrong arguments, or inputs that cannot be used: the next start would end in the same way.
        if let Exit::Code(2 | 3) = exit {
            return Some(format!("it {}", describe(exit, true)));
        }
        if self.hung_starts >= MAX_HUNG_STARTS {
            return Some(format!(
                "{MAX_HUNG_STARTS} starts in a row gave no sign of life within {} s",
                self.ready_s
            ));
        }
        let is_short = now.saturating_sub(self.spawned_at) < LONG_LIFE;
        self.short_lives = if is_short { self.short_lives + 1 } else { 0 };
        // A process that is killed while it works, by a person or by the kernel for lack of
        // memory, says nothing about the next start.
        if is_short || !worked || exit != Exit::Signal(SIGKILL) {
            self.crashes.push_back(now);
        }
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
                describe(exit, true)
            )
        })
    }

    /// The first short life is answered at once, the following with a delay.
    fn backoff(&self) -> u64 {
        match self.short_lives {
            0 | 1 => 0,
            // A shift by 64 or more would overflow.
            n => BACKOFF_MAX.min(BACKOFF_FIRST << (n - 2).min(10)),
        }
    }
}

/// An exit in words a person can act on. SIGBUS has two causes, which the room in memory
/// tells apart: a page that a full file system cannot supply, and a file that was
/// truncated while it was mapped.
fn describe(exit: Exit, has_room: bool) -> String {
    match exit {
        Exit::Code(0) => "ended without being asked".to_owned(),
        Exit::Code(101) => "panicked (exit code 101)".to_owned(),
        Exit::Code(code) => format!("ended with exit code {code}"),
        Exit::Signal(SIGBUS) if has_room => {
            "was ended by SIGBUS: a file of the run that it had mapped was truncated".to_owned()
        }
        Exit::Signal(SIGBUS) => {
            "was ended by SIGBUS: shared memory or the run directory is full; free space there"
                .to_owned()
        }
        Exit::Signal(SIGKILL) => "was killed (SIGKILL)".to_owned(),
        Exit::Signal(11) => "was ended by SIGSEGV".to_owned(),
        Exit::Signal(25) => {
            "was ended by SIGXFSZ: a file reached the limit for its size (`ulimit -f`)".to_owned()
        }
        Exit::Signal(signal) => format!("was ended by signal {signal}"),
    }
}
