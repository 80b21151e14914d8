//! Lines of the script have their effect once.

use std::collections::BTreeMap;

use cell_model::cells::script::{ScriptAction, ScriptLine, Trigger};
use ipc_types::topic::Process;

use super::{Check, Moment, Seen, Verdict, fail_if};
use crate::model::{Model, News, Signal};
use crate::plan::Plan;

/// A line has had its effect this many ticks after its time.
const DONE_TICKS: u64 = 2_000;
/// All processes have started by then (s).
const STARTED_S: f64 = 0.5;
/// Lines of one process that are nearer than this may share one effect (ticks): a process is not
/// killed while it starts, nor twice.
const APART_TICKS: u64 = 300;

pub(super) fn all(plan: &Plan, model: &Model) -> Vec<Box<dyn Check>> {
    // Every other signal has a fault as its cause.
    if plan.script.is_empty() || !plan.faults.is_empty() {
        return Vec::new();
    }
    let lines = &model.spec.script;
    let of = model
        .processes()
        .into_iter()
        .map(|process| (process, times(lines, process)));
    let due = of
        .filter_map(|(process, times)| Some((process, times?)))
        .collect();
    vec![Box::new(Once {
        due,
        killed: BTreeMap::new(),
        tick: 0,
    })]
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
