//! A process that sleeps at its doorbell is woken by the message that it waits for.

use ipc_types::topic::Process;
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED};
use ipc_types::{Decision, WorldState};

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::News;
use crate::plan::{Fault, MS, Plan};

/// Ticks between two decisions.
const DECISION_TICKS: u64 = 10;
/// From a state to the decision on it (us): less than the 5 ms after which a process looks without a
/// ring.
const LATEST_US: u64 = 3_500;
/// Time after which a fault has no effect on the task any more (ms).
const QUIET_MS: u64 = 300;

pub(super) fn all(plan: &Plan) -> Vec<Box<dyn Check>> {
    // Lines of a script disturb processes at ticks that depend on the run.
    if plan.lockstep || !plan.script.is_empty() {
        return Vec::new();
    }
    // Without a monitor, which may start late, the task is not started.
    vec![Box::new(Wakes {
        due: None,
        quiet_ns: 0,
        is_away: true,
    })]
}

/// The decision on a state follows within milliseconds, unless something keeps the task from it.
struct Wakes {
    /// Generation and tick of a state that asks for a decision, and when it was published (ns).
    due: Option<(u32, u64, u64)>,
    /// Until when nothing is asked (ns).
    quiet_ns: u64,
    /// The task hangs, or does not exist.
    is_away: bool,
}

impl Wakes {
    fn state(&mut self, now_ns: u64, state: &WorldState) -> Verdict {
        let header = &state.header;
        if let Some((generation, tick, at_ns)) = self.due
            && now_ns > at_ns + LATEST_US * 1000
        {
            self.due = None;
            let us = (now_ns - at_ns) / 1000;
            fail_if(generation == header.generation, || {
                format!("no decision on the state of tick {tick}, {us} us after it")
            })?;
        }
        let flags = [FLAG_PAUSED, FLAG_LOCKSTEP, FLAG_ENDING];
        let is_asked = header.tick.is_multiple_of(DECISION_TICKS) && now_ns >= self.quiet_ns;
        if is_asked && !self.is_away && !flags.into_iter().any(|flag| state.has(flag)) {
            self.due = Some((header.generation, header.tick, now_ns));
        }
        Ok(())
    }

    fn decision(&mut self, now_ns: u64, decision: &Decision) -> Verdict {
        let answered = |(generation, tick, _): &mut (u32, u64, u64)| {
            decision.header.answers(*generation) && decision.header.tick >= *tick
        };
        let due = self.due.take_if(answered);
        let us = due.map_or(0, |(_, _, at_ns)| (now_ns - at_ns) / 1000);
        fail_if(us > LATEST_US, || {
            let tick = decision.header.tick;
            format!("the decision on tick {tick} took {us} us")
        })
    }

    /// `process` began to work, or is not there any more.
    fn changed(&mut self, now_ns: u64, process: Process, is_away: bool) {
        if matches!(process, Process::Task | Process::Physics) {
            self.quiet(now_ns, 0);
        }
        if process == Process::Task {
            self.is_away = is_away;
        }
    }

    fn quiet(&mut self, now_ns: u64, for_ms: u64) {
        self.due = None;
        self.quiet_ns = self.quiet_ns.max(now_ns + (for_ms + QUIET_MS) * MS);
    }
}

/// For how long messages come again (ms): one may displace a newer one, which is lost then.
fn repeated_ms(fault: &Fault) -> u64 {
    match fault {
        Fault::Repeat { topic, count, .. } if topic == "decision" => {
            DECISION_TICKS * u64::from(*count)
        }
        Fault::Repeat { count, .. } => u64::from(*count),
        _ => 0,
    }
}

impl Check for Wakes {
    fn number(&self) -> u32 {
        33
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let now_ns = moment.now_ns;
        match moment.seen {
            // The doorbell of physics must not ring before its message can be read.
            Seen::Fault(Fault::Preempt { process, .. }) if *process != Process::Task.name() => {}
            Seen::Fault(fault) => {
                let is_of = |of: Process| fault.process() == Some(of.name().as_str());
                let is_other =
                    fault.process().is_some() && !is_of(Process::Task) && !is_of(Process::Physics);
                if !is_other {
                    self.quiet(now_ns, fault.length_ms().max(repeated_ms(fault)));
                    self.is_away |= matches!(fault, Fault::Hang { .. }) && is_of(Process::Task);
                }
            }
            Seen::News(News::Began(of, _)) => self.changed(now_ns, *of, false),
            Seen::News(News::Gone(of, ..) | News::Signalled(of, _)) => {
                self.changed(now_ns, *of, true);
            }
            Seen::State(state) => return self.state(now_ns, state),
            Seen::Decision(decision) => return self.decision(now_ns, decision),
            _ => {}
        }
        Ok(())
    }
}
