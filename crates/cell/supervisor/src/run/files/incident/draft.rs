//! Drafts of incidents, which a thread completes with the last cycles and writes.

use std::path::PathBuf;
use std::sync::mpsc::Receiver;

use cell_rt::{BlackBox, BoxedCycle};
use cell_run::incident::{Incident, Incidents, LoopTrace, value_names};
use ipc_types::topic::Process;

use super::AFTER_NS;
use crate::say;

/// How long before its first event an incident starts (ns).
const BEFORE_NS: u64 = 3_000_000_000;

/// An incident to be written.
pub(super) struct Draft {
    pub(super) incident: Incident,
    pub(super) first_ns: u64,
    /// Where the last cycles of each loop are. A successor appends to them, so the
    /// writer has seconds to read them.
    pub(super) rings: Vec<(Process, PathBuf)>,
    /// State files, by name.
    pub(super) files: Vec<(&'static str, Vec<u8>)>,
}

/// Writes drafts until there will be no more.
pub(super) fn write_all(incidents: &Incidents, drafts: &Receiver<Draft>) {
    let mut said = false;
    for draft in drafts {
        let number = draft.incident.head.number;
        if let Err(error) = draft.save(incidents)
            // Once: a full disk refuses every draft.
            && !std::mem::replace(&mut said, true)
        {
            say::warn(format_args!(
                "incident {number} is not kept: {error}: {}",
                incidents.path(number).display()
            ));
        }
    }
}

impl Draft {
    fn save(mut self, incidents: &Incidents) -> std::io::Result<()> {
        let first_ns = self.first_ns;
        let trace = |(process, path): &(Process, PathBuf)| {
            // A process that could not make its ring has said so.
            let ring = BlackBox::read(path).ok()?;
            Some(trace(*process, &ring, first_ns))
        };
        self.incident.loops = self.rings.iter().filter_map(trace).collect();
        incidents.save(&self.incident)?;
        for (name, bytes) in &self.files {
            std::fs::write(incidents.path(self.incident.head.number).join(name), bytes)?;
        }
        Ok(())
    }
}

/// The cycles of `ring` around `first_ns`.
fn trace(process: Process, ring: &[BoxedCycle], first_ns: u64) -> LoopTrace {
    let mut trace = LoopTrace {
        process: process.name(),
        ..LoopTrace::default()
    };
    let names = value_names(process);
    let names = names
        .iter()
        .enumerate()
        .filter(|(_, name)| !name.is_empty());
    let span = first_ns.saturating_sub(BEFORE_NS)..=first_ns + AFTER_NS;
    for cycle in ring.iter().filter(|cycle| span.contains(&cycle.began_ns)) {
        if let Some(cause) = cycle.cause {
            let overrun = (trace.tick.len(), cause.name().to_owned());
            trace.overruns.push(overrun);
        }
        trace.generation.push(cycle.generation);
        trace.tick.push(cycle.tick);
        trace.at_ms.push(ms(cycle.began_ns, first_ns));
        trace.late_us.push(us(cycle.late_ns));
        trace.body_us.push(us(cycle.body_ns));
        for (index, name) in names.clone() {
            let values = trace.values.entry((*name).to_owned()).or_default();
            values.push(rounded(cycle.values[index]));
        }
    }
    trace
}

/// From `zero_ns` to `ns`, in milliseconds with three decimals.
pub(super) fn ms(ns: u64, zero_ns: u64) -> f64 {
    let us = |ns: u64| (ns / 1_000) as f64;
    (us(ns) - us(zero_ns)) / 1_000.0
}

fn us(ns: u32) -> f64 {
    f64::from(ns / 100) / 10.0
}

/// With four decimals: an incident is read by people, too.
fn rounded(value: f32) -> f64 {
    (f64::from(value) * 10_000.0).round() / 10_000.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_rt::overrun::Cause;

    #[test]
    fn a_trace_has_the_cycles_around_the_first_event() {
        let second = 1_000_000_000;
        let cycle = |began_ns, cause| BoxedCycle {
            began_ns,
            late_ns: 1_234_567,
            body_ns: 50_000,
            cause,
            values: [5.0, 0.123_45, 0.0, 0.0],
            ..BoxedCycle::default()
        };
        let ring = [
            cycle(second, None),
            cycle(8 * second, Some(Cause::Preemption)),
            cycle(10 * second + 2_500_000, None),
            cycle(12 * second, None),
        ];
        let trace = trace(Process::Physics, &ring, 10 * second);
        assert_eq!(trace.at_ms, [-2000.0, 2.5]);
        assert_eq!((trace.late_us[0], trace.body_us[1]), (1234.5, 50.0));
        assert_eq!(trace.overruns, [(0, "preemption".to_owned())]);
        assert_eq!(trace.values["arm 0 fastest joint (rad/s)"], [0.1235; 2]);
        assert_eq!(trace.values.len(), 4);
    }
}
