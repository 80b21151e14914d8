//! Lines of the script have their effect once, and pauses end.

use std::collections::BTreeMap;

use cell_model::cells::script::{ScriptAction, ScriptLine, Trigger};
use ipc_types::topic::Process;
use ipc_types::world::FLAG_PAUSED;

use super::{Check, Moment, Seen, Verdict, fail_if, ms};
use crate::model::{Model, News, Signal};
use crate::plan::{MS, Plan};

/// A line has had its effect this many ticks after its time.
const DONE_TICKS: u64 = 2_000;
/// All processes have started by then (s).
const STARTED_S: f64 = 0.5;
/// Restarts of physics and delays of the launcher during a pause take at most so long (ms).
const RECOVERED_MS: u64 = 4_000;
/// Lines of one process that are nearer than this may share one effect (ticks): a process is not
/// killed while it starts, nor twice.
const APART_TICKS: u64 = 300;

pub(super) fn all(plan: &Plan, model: &Model) -> Vec<Box<dyn Check>> {
    let lines = &model.spec.script;
    let mut all: Vec<Box<dyn Check>> = Vec::new();
    // A pause of people lasts until they resume.
    if plan.people.is_empty() {
        all.extend(Pauses::of(lines).map(|pauses| Box::new(pauses) as Box<dyn Check>));
    }
    // Every other signal has a fault as its cause.
    if plan.script.is_empty() || !plan.faults.is_empty() {
        return all;
    }
    let of = model
        .processes()
        .into_iter()
        .map(|process| (process, times(lines, process)));
    let due = of
        .filter_map(|(process, times)| Some((process, times?)))
        .collect();
    all.push(Box::new(Once {
        due,
        killed: BTreeMap::new(),
        tick: 0,
    }));
    all
}

/// A pause of the script ends, whatever is restarted meanwhile.
struct Pauses {
    /// Virtual time of all pauses of the script, and of recoveries (ns).
    most_ns: u64,
    /// Since when the cell is paused.
    since_ns: Option<u64>,
}

impl Pauses {
    fn of(lines: &[ScriptLine]) -> Option<Self> {
        let for_s = lines.iter().filter_map(|line| match line.action {
            ScriptAction::Pause { for_s } => for_s,
            _ => None,
        });
        let all_s: f64 = for_s.sum();
        (all_s > 0.0).then(|| Self {
            most_ns: (crate::plan::ticks(all_s) + RECOVERED_MS) * MS,
            since_ns: None,
        })
    }
}

impl Check for Pauses {
    fn number(&self) -> u32 {
        22
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        let Seen::State(state) = moment.seen else {
            return Ok(());
        };
        if !state.has(FLAG_PAUSED) {
            self.since_ns = None;
            return Ok(());
        }
        let since_ns = *self.since_ns.get_or_insert(moment.now_ns);
        let paused_ns = moment.now_ns - since_ns;
        fail_if(paused_ns > self.most_ns, || {
            format!("a pause of the script lasts for {} ms", ms(paused_ns))
        })
    }
}

/// Ticks at which lines kill `process`; `None` where a line stops it, which may look like a hang.
fn times(lines: &[ScriptLine], process: Process) -> Option<Vec<u64>> {
    let mut ticks = Vec::new();
    for line in lines {
        match &line.action {
            ScriptAction::Kill { process: name } if *name == process.name() => {
                let Trigger::Time { at_s } = line.trigger else {
                    return None;
                };
                // A process that was not started yet is not killed.
                if at_s < STARTED_S {
                    return None;
                }
                ticks.push(crate::plan::ticks(at_s));
            }
            ScriptAction::Stop { process: name, .. }
            | ScriptAction::Restart { process: name, .. }
                if *name == process.name() =>
            {
                return None;
            }
            // What lacks a core or room may be killed for it, or not be started.
            ScriptAction::Starve { .. } | ScriptAction::Fill { .. } => return None,
            _ => {}
        }
    }
    ticks.sort_unstable();
    Some(ticks)
}

struct Once {
    /// By process: ticks of the lines that kill it.
    due: Vec<(Process, Vec<u64>)>,
    killed: BTreeMap<Process, usize>,
    tick: u64,
}

impl Check for Once {
    fn number(&self) -> u32 {
        22
    }

    fn see(&mut self, moment: &Moment<'_>) -> Verdict {
        match moment.seen {
            Seen::State(state) => self.tick = state.header.tick,
            Seen::News(News::Signalled(process, Signal::Kill)) => {
                *self.killed.entry(*process).or_default() += 1;
            }
            _ => {}
        }
        Ok(())
    }

    fn end(&mut self, _: u64) -> Verdict {
        for (process, ticks) in &self.due {
            let killed = self.killed.get(process).copied().unwrap_or(0);
            let mut last = None;
            let mut least = 0;
            for tick in ticks.iter().filter(|tick| **tick + DONE_TICKS < self.tick) {
                least += usize::from(last.is_none_or(|last| *tick > last + APART_TICKS));
                last = Some(*tick);
            }
            fail_if(killed < least || killed > ticks.len(), || {
                let lines = ticks.len();
                format!(
                    "{} was killed {killed} times for {lines} lines, of which {least} are over",
                    process.name()
                )
            })?;
        }
        Ok(())
    }
}
