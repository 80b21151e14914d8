//! The launcher restarts what hangs or died, and nothing else.

use std::collections::BTreeMap;

use ipc_types::topic::Process;
use ipc_types::world::FLAG_PAUSED;

use super::{Check, Moment, Seen, Verdict, fail_if, ms};
use crate::model::{Model, News, Signal};
use crate::plan::{Fault, MS, Plan};

/// A process is left alone for this long after its start (ms).
const QUIET_MS: u64 = 50;
/// After the last fault a cell works again within this (ms), in lockstep within the other.
const RECOVERY_MS: u64 = 5_000;
const RECOVERY_LOCKSTEP_MS: u64 = 25_000;
/// So many deaths of a process within ten seconds end the run.
const DEATHS: usize = 5;
const DEATHS_MS: u64 = 10_000;

pub(super) fn all(plan: &Plan, model: &Model) -> Vec<Box<dyn Check>> {
    let processes = model.processes();
    vec![
        Box::new(Starts::default()),
        Box::new(Hangs::new(plan)),
        Box::new(Verdicts::default()),
        Box::new(Recovery::new(plan, processes)),
    ]
}

/// One process of a kind, numbered starts, and no signal during a start.
#[derive(Default)]
struct Starts {
    /// Generation, whether it exists, and when it was spawned.
    of: BTreeMap<Process, (u32, bool, u64)>,
}

impl Check for Starts {
    fn number(&self) -> u32 {
        23
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::News(news) = moment.seen else {
            return Ok(());
        };
        match news {
            News::Spawned(process, generation) => {
                let of = self.of.entry(*process).or_default();
                let is_next = *generation == of.0 + 1 && !of.1;
                *of = (*generation, true, moment.now_ns);
                fail_if(!is_next, || {
                    format!(
                        "{} was started as {generation} beside another",
                        process.name()
                    )
                })
            }
            News::Gone(process, ..) => {
                self.of.entry(*process).or_default().1 = false;
                Ok(())
            }
            News::Signalled(process, _) => {
                let age = moment.now_ns - self.of.get(process).map_or(0, |of| of.2);
                fail_if(ms(age) < QUIET_MS, || {
                    format!(
                        "{} got a signal {} ms after its start",
                        process.name(),
                        ms(age)
                    )
                })
            }
            _ => Ok(()),
        }
    }
}

/// What hangs is replaced in time, and what lacks a core is not.
struct Hangs {
    plan: Plan,
    /// By process: until when it is stopped, and until when it lacks a core (ns).
    stopped: BTreeMap<Process, (u64, u64)>,
    /// Until when one that was asked to end has time for it (ns).
    ending: BTreeMap<Process, u64>,
    starved: BTreeMap<Process, u64>,
    /// When it began to work, by process.
    works: BTreeMap<Process, u64>,
    /// The launcher was not scheduled until then.
    launcher_until_ns: u64,
    full_until_ns: u64,
}

impl Hangs {
    fn new(plan: &Plan) -> Self {
        Self {
            plan: plan.clone(),
            stopped: BTreeMap::new(),
            ending: BTreeMap::new(),
            starved: BTreeMap::new(),
            works: BTreeMap::new(),
            launcher_until_ns: 0,
            full_until_ns: 0,
        }
    }

    /// The longest silence of a process that works (ms).
    fn limit_ms(&self, process: Process) -> u64 {
        match process {
            Process::Monitor => 2_000,
            _ if self.plan.lockstep => 5_000,
            Process::Physics | Process::Controller(_) if self.plan.fifo => 100,
            _ => 500,
        }
    }

    fn fault(&mut self, now_ns: u64, fault: &Fault) {
        let of = |name: &str| crate::plan::process(name, 2);
        match fault {
            Fault::Stop { process, for_ms } => {
                if let Some(process) = of(process) {
                    let until_ns = now_ns + for_ms * MS;
                    let of = self.stopped.entry(process).or_insert((now_ns, until_ns));
                    *of = (of.0.max(now_ns), of.1.max(until_ns));
                }
            }
            Fault::Hang { process } => {
                if let Some(process) = of(process) {
                    let of = self.stopped.entry(process).or_insert((now_ns, 0));
                    *of = (of.0.max(now_ns), u64::MAX);
                }
            }
            Fault::Starve { process, for_ms } => {
                if let Some(process) = of(process) {
                    self.starved.insert(process, now_ns + for_ms * MS);
                }
            }
            Fault::Launcher { for_ms } => {
                self.launcher_until_ns = self.launcher_until_ns.max(now_ns + for_ms * MS);
            }
            Fault::Full { for_ms } => {
                self.full_until_ns = self.full_until_ns.max(now_ns + for_ms * MS);
            }
            _ => {}
        }
    }

    /// The launcher says that a process hangs: it has to be stopped.
    fn accused(&self, text: &str) -> Verdict {
        let hangs = text.contains(" hangs: ") || text.contains(" gave no sign of life ");
        let mut stopped = self.stopped.keys();
        let is_stopped = stopped.any(|process| text.starts_with(&process.name()));
        // Those that a script stops are not known here.
        let by_script = self.plan.script.iter().any(|line| line.contains("stop"));
        fail_if(hangs && !is_stopped && !by_script, || {
            format!("of a process that works it was said: {text}")
        })
    }

    /// A stopped process that worked has to be gone by now.
    fn overdue(&self, now_ns: u64) -> Verdict {
        for (process, (since_ns, until_ns)) in &self.stopped {
            let Some(began_ns) = self.works.get(process) else {
                continue;
            };
            // Two turns of the launcher, and what it was not scheduled.
            let limit_ns = (self.limit_ms(*process) + 50) * MS;
            let ending_ns = self.ending.get(process).unwrap_or(&0);
            let since_ns = since_ns.max(ending_ns);
            let due_ns = since_ns.max(&self.launcher_until_ns).max(began_ns) + limit_ns;
            let starves = self
                .starved
                .get(process)
                .is_some_and(|s| s + limit_ns > *since_ns);
            let is_late = now_ns > due_ns && due_ns < *until_ns && !starves;
            fail_if(is_late, || {
                let for_ms = ms(now_ns - *since_ns);
                format!(
                    "{} hangs for {for_ms} ms and was not replaced",
                    process.name()
                )
            })?;
        }
        Ok(())
    }
}

impl Check for Hangs {
    fn number(&self) -> u32 {
        24
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let now_ns = moment.now_ns;
        match moment.seen {
            Seen::Fault(fault) => self.fault(now_ns, fault),
            Seen::Health(process, _) => {
                self.works.entry(process).or_insert(now_ns);
                // One that works is not stopped any more.
                self.stopped
                    .retain(|of, (since, _)| *of != process || *since == now_ns);
            }
            Seen::News(News::Gone(process, ..)) => {
                self.stopped.remove(process);
                self.ending.remove(process);
                self.starved.remove(process);
                self.works.remove(process);
            }
            Seen::News(News::Warned(text)) => return self.accused(text),
            Seen::News(News::Signalled(process, Signal::Terminate)) => {
                // It may be stopped, or hang, before or after that.
                self.ending.insert(*process, now_ns + 1_000 * MS);
            }
            Seen::News(News::Signalled(process, Signal::Kill)) => {
                let starves = self
                    .starved
                    .get(process)
                    .is_some_and(|until| now_ns < *until);
                let hangs = self.stopped.contains_key(process);
                let starts = !self.works.contains_key(process);
                // The launcher kills for a script, too.
                let by_itself = self.plan.script.is_empty();
                return fail_if(starves && !hangs && !starts && by_itself, || {
                    format!("{} was killed for want of a core", process.name())
                });
            }
            Seen::Looked if now_ns > self.launcher_until_ns => return self.overdue(now_ns),
            _ => {}
        }
        Ok(())
    }
}

/// A run is given up only after so many deaths of one process.
#[derive(Default)]
struct Verdicts {
    /// When each died.
    deaths: Vec<(Process, u64)>,
    full_until_ns: u64,
}

impl Check for Verdicts {
    fn number(&self) -> u32 {
        26
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::Fault(Fault::Full { for_ms }) => {
                self.full_until_ns = self.full_until_ns.max(moment.now_ns + for_ms * MS);
                Ok(())
            }
            // What ends without room is not to blame for it.
            Seen::News(News::Gone(..)) if moment.now_ns < self.full_until_ns => Ok(()),
            Seen::News(News::Gone(process, ..)) => {
                self.deaths.push((*process, moment.now_ns));
                Ok(())
            }
            Seen::GaveUp(why) => {
                let since_ns = moment.now_ns.saturating_sub(DEATHS_MS * MS);
                let recent = self.deaths.iter().filter(|(_, at_ns)| *at_ns >= since_ns);
                let of = |process: &Process| {
                    recent.clone().filter(|(other, _)| other == process).count()
                };
                let many = self.deaths.iter().any(|(process, _)| of(process) > DEATHS);
                fail_if(!many, || format!("the run was given up: {why}"))
            }
            _ => Ok(()),
        }
    }
}

/// Some seconds after the last fault every process works, and no arm waits for another.
struct Recovery {
    /// Time after the last fault (ms).
    within_ms: u64,
    processes: Vec<Process>,
    last_fault_ns: u64,
    /// When each gave its last sign of life.
    alive: BTreeMap<Process, u64>,
    /// Last tick of a decision, and of a state with its time.
    decision_tick: u64,
    state: (u64, u64),
    /// Tick of the oldest command that is in force.
    command_tick: u64,
    holds: bool,
    paused: bool,
    ended: bool,
}

impl Recovery {
    fn new(plan: &Plan, processes: Vec<Process>) -> Self {
        Self {
            within_ms: if plan.lockstep {
                RECOVERY_LOCKSTEP_MS
            } else {
                RECOVERY_MS
            },
            processes,
            last_fault_ns: 0,
            alive: BTreeMap::new(),
            decision_tick: 0,
            state: (0, 0),
            command_tick: 0,
            holds: false,
            paused: false,
            ended: false,
        }
    }
}

impl Check for Recovery {
    fn number(&self) -> u32 {
        27
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::Fault(fault) => {
                let end_ns = moment.now_ns + fault.length_ms() * MS;
                self.last_fault_ns = self.last_fault_ns.max(end_ns);
            }
            Seen::News(News::Stopped(..) | News::Gone(..)) => {
                self.last_fault_ns = self.last_fault_ns.max(moment.now_ns);
            }
            Seen::Health(process, _) => {
                self.alive.insert(process, moment.now_ns);
            }
            Seen::Decision(decision) => self.decision_tick = decision.header.tick,
            Seen::State(state) => {
                self.state = (state.header.tick, moment.now_ns);
                self.paused = state.has(FLAG_PAUSED);
                self.holds = state.arms().iter().any(|arm| arm.stop_action > 0);
                let commands = state.arms().iter().map(|arm| arm.command_tick);
                self.command_tick = commands.min().unwrap_or(state.header.tick);
            }
            Seen::GaveUp(_) => self.ended = true,
            // The cell works without it, and tries it again much later.
            Seen::News(News::Warned(text)) if text.starts_with("monitor has stopped") => {
                self.processes.retain(|of| *of != Process::Monitor);
            }
            _ => {}
        }
        Ok(())
    }

    fn end(&mut self, now_ns: u64) -> Verdict {
        if self.ended || now_ns < self.last_fault_ns + self.within_ms * MS {
            return Ok(());
        }
        for process in &self.processes {
            let alive_ns = self.alive.get(process).copied().unwrap_or(0);
            fail_if(now_ns - alive_ns > 1000 * MS, || {
                format!(
                    "{} does not work, {} s after the last fault",
                    process.name(),
                    { (now_ns - self.last_fault_ns) / (1000 * MS) }
                )
            })?;
        }
        let (tick, at_ns) = self.state;
        let age = tick.saturating_sub(self.decision_tick);
        let command_age = tick.saturating_sub(self.command_tick);
        let is_old = age > 100 || command_age > 100 || now_ns - at_ns > 1000 * MS;
        fail_if(!self.paused && (is_old || self.holds), || {
            format!(
                "after the last fault: decision {age} ticks old, command {command_age}, state \
                 {} ms, arm holds: {}",
                ms(now_ns - at_ns),
                self.holds
            )
        })
    }
}
