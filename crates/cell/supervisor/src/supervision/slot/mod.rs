//! One process under supervision.

mod exits;

use std::collections::VecDeque;

use ipc_types::topic::Process;

use super::{Action, MS, Rules};

/// A process shows its first health message within this.
const READY_DEADLINE: u64 = 2_000 * MS;
/// A task in Python within this: imports from a cold disk.
const READY_DEADLINE_PYTHON: u64 = 20_000 * MS;
/// It is left alone for this long after its start: a signal during start-up
/// can leave a slot of the shared memory taken forever.
const MIN_RUN: u64 = 50 * MS;
/// Between SIGTERM and SIGKILL.
const STOP_GRACE: u64 = 1_000 * MS;
/// So many starts in a row without a sign of life, and it is given up: they
/// take too long to fill the window.
pub(super) const MAX_HUNG_STARTS: u32 = 3;
/// A process that is asked to end and gets no core may take this much longer.
const MAX_EXTRA_GRACE: u64 = 10_000 * MS;
/// A process that starves is reported once within this.
const REPORT_PERIOD: u64 = 60_000 * MS;
/// Hang limit while physics waits for every process.
const HANG_LOCKSTEP: u64 = 5_000 * MS;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lifecycle {
    /// Never started.
    NotStarted,
    /// Started, no health message yet.
    Starting,
    /// Shows itself.
    Up,
    /// SIGTERM sent; SIGKILL follows at that time.
    Leaving(u64),
    /// SIGKILL sent.
    Killed,
    /// Comes back at that time.
    Waiting(u64),
    /// Gone for good.
    Down,
}

#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub(super) process: Process,
    pub(super) state: Lifecycle,
    pub(super) generation: u32,
    spawned_at: u64,
    crashes: VecDeque<u64>,
    hung_starts: u32,
    /// The limit that the last of them had (s).
    ready_s: u64,
    /// Lives shorter than [`exits::LONG_LIFE`] in a row.
    short_lives: u32,
    /// The next exit was asked for and counts as no crash.
    commanded: bool,
    /// It ends already: how is known soon.
    pub(super) dying: bool,
    /// A restart was asked for: `Some(gently)`.
    wanted: Option<bool>,
    fifo: bool,
    cycles: u64,
    /// Time without a new cycle.
    silent_ns: u64,
    /// The part of it in which it could do nothing for lack of a core, disk or page.
    starved_ns: u64,
    /// Before this it is not reported as starving again.
    quiet_until: u64,
    /// How much longer it may take to leave.
    extra_grace: u64,
    /// Delay before the next start of a monitor that was given up; 0: it was not.
    retry: u64,
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
            ready_s: 0,
            short_lives: 0,
            commanded: false,
            dying: false,
            wanted: None,
            fifo: false,
            cycles: 0,
            silent_ns: 0,
            starved_ns: 0,
            quiet_until: 0,
            extra_grace: 0,
            retry: 0,
        }
    }

    /// Whether a process exists.
    pub(super) fn runs(&self) -> bool {
        matches!(
            self.state,
            Lifecycle::Starting | Lifecycle::Up | Lifecycle::Leaving(_) | Lifecycle::Killed
        )
    }

    /// A monitor that was given up, and does not run again yet.
    pub(super) fn is_given_up(&self) -> bool {
        self.retry > 0 && self.process == Process::Monitor && self.state != Lifecycle::Up
    }

    /// For how long it has given no sign of life (ns), while it should.
    pub(super) fn silence(&self) -> u64 {
        match self.state {
            Lifecycle::Starting | Lifecycle::Up => self.silent_ns,
            _ => 0,
        }
    }

    pub(super) fn listened(&mut self, ns: u64) {
        self.silent_ns += ns;
    }

    pub(super) fn starved(&mut self, ns: u64) {
        // A look may reach back to before the last sign of life; only silence can be excused.
        self.starved_ns = (self.starved_ns + ns).min(self.silent_ns);
        if let Lifecycle::Leaving(until) = &mut self.state {
            // Without a core the recorder was killed before it had written the index of its file.
            let extra = ns.min(self.extra_grace);
            self.extra_grace -= extra;
            *until += extra;
        }
    }

    /// Time without a new cycle it has to answer for.
    fn idle_ns(&self) -> u64 {
        self.silent_ns - self.starved_ns
    }

    fn forget_silence(&mut self) {
        self.silent_ns = 0;
        self.starved_ns = 0;
    }

    pub(super) fn alive(&mut self, cycles: u64, fifo: bool) {
        if self.state == Lifecycle::Starting {
            self.state = Lifecycle::Up;
            self.forget_silence();
            self.hung_starts = 0;
            self.retry = 0;
        }
        self.fifo = fifo;
        // Task and monitor have no cycle while nothing new arrives, such as in
        // a pause; their message comes from the same loop and shows they live.
        let may_wait = matches!(self.process, Process::Task | Process::Monitor);
        if cycles != self.cycles || may_wait {
            self.cycles = cycles;
            self.forget_silence();
        }
    }

    pub(super) fn ask_restart(&mut self, now: u64, gently: bool) {
        match self.state {
            Lifecycle::Starting | Lifecycle::Up => self.wanted = Some(gently),
            // A request of a person also brings back what was given up.
            Lifecycle::Waiting(_) | Lifecycle::Down => {
                self.retry = 0;
                self.state = Lifecycle::Waiting(now);
            }
            Lifecycle::NotStarted | Lifecycle::Leaving(_) | Lifecycle::Killed => {}
        }
    }

    /// A process that does not exist now will not exist later.
    pub(super) fn forget_plans(&mut self) {
        self.wanted = None;
        if matches!(self.state, Lifecycle::NotStarted | Lifecycle::Waiting(_)) {
            self.state = Lifecycle::Down;
        }
    }

    /// Whether it gave no sign of life in so many starts that something in its way has to
    /// be taken for damaged. A monitor is no reason to touch the others.
    pub(super) fn never_works(&self) -> bool {
        self.hung_starts >= MAX_HUNG_STARTS && self.process != Process::Monitor
    }

    /// Resets all but the generation: the next start resumes from the kept state.
    pub(super) fn begin_again(&mut self) {
        *self = Self {
            generation: self.generation,
            ..Self::new(self.process)
        };
    }

    pub(super) fn keep(
        &mut self,
        now: u64,
        rules: Rules,
        may_start: bool,
        has_room: bool,
        out: &mut Vec<Action>,
    ) {
        match self.state {
            Lifecycle::NotStarted if may_start => self.spawn(now, out),
            Lifecycle::Waiting(until) if now >= until && has_room => self.spawn(now, out),
            Lifecycle::Leaving(until) if now >= until => self.kill(out),
            Lifecycle::Starting | Lifecycle::Up => self.watch(now, rules, out),
            _ => {}
        }
    }

    fn spawn(&mut self, now: u64, out: &mut Vec<Action>) {
        self.generation += 1;
        self.state = Lifecycle::Starting;
        self.spawned_at = now;
        self.cycles = 0;
        self.dying = false;
        self.forget_silence();
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
                self.terminate(now, out);
            } else {
                self.kill(out);
            }
            return;
        }
        // On a busy machine a killed process ends late; it must not be reported as one that hangs.
        if !rules.watchdog || self.dying {
            return;
        }
        let limit = self.silence_limit(rules);
        if self.idle_ns() < limit {
            if self.silent_ns >= limit {
                self.report_starvation(now, out);
            }
            return;
        }
        let what = if self.state == Lifecycle::Starting {
            self.hung_starts += 1;
            self.ready_s = limit / (1_000 * MS);
            format!(
                "gave no sign of life within {} s of its start",
                self.ready_s
            )
        } else {
            format!("hangs: no new cycle for {} ms", self.silent_ns / MS)
        };
        out.push(Action::Lost {
            process: self.process,
            what,
        });
        self.kill(out);
    }

    /// Once per episode: it may last for minutes.
    fn report_starvation(&mut self, now: u64, out: &mut Vec<Action>) {
        if now >= self.quiet_until {
            out.push(Action::Starves {
                process: self.process,
                starved_ns: self.starved_ns,
                silent_ns: self.silent_ns,
            });
        }
        self.quiet_until = now + REPORT_PERIOD;
    }

    fn terminate(&mut self, now: u64, out: &mut Vec<Action>) {
        self.state = Lifecycle::Leaving(now + STOP_GRACE);
        self.extra_grace = MAX_EXTRA_GRACE;
        out.push(Action::Terminate {
            process: self.process,
        });
    }

    pub(super) fn kill(&mut self, out: &mut Vec<Action>) {
        self.state = Lifecycle::Killed;
        out.push(Action::Kill {
            process: self.process,
        });
    }

    /// For how long it may give no sign of life while it could. Without real-time
    /// scheduling a short lack of processor time is not even a report.
    fn silence_limit(&self, rules: Rules) -> u64 {
        if self.state == Lifecycle::Starting {
            let imports = rules.python_task && self.process == Process::Task;
            return if imports {
                READY_DEADLINE_PYTHON
            } else {
                READY_DEADLINE
            };
        }
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
                self.terminate(now, out);
            }
            Lifecycle::Leaving(until) if now >= until => self.kill(out),
            _ => {}
        }
    }
}
