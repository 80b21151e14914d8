//! Incidents of the run, which the launcher keeps, for the log and the timeline.

use cell_model::runs::incident::{Head, Incidents};
use cell_model::runs::spec::RunSpec;

/// How often the directory is looked at (ns).
const PERIOD_NS: u64 = 500_000_000;

/// Tells each incident of one run once.
pub(crate) struct IncidentWatch {
    incidents: Incidents,
    run: u64,
    newest: u32,
    next_ns: u64,
}

impl IncidentWatch {
    /// Of the run of `spec`.
    pub(crate) fn new(spec: &RunSpec) -> Self {
        Self {
            incidents: Incidents::at(spec.incidents_dir.clone()),
            run: spec.run,
            newest: 0,
            next_ns: 0,
        }
    }

    /// Those that are new. A monitor that was restarted tells all of its run again.
    pub(crate) fn news(&mut self, now_ns: u64) -> Vec<Head> {
        if now_ns < self.next_ns {
            return Vec::new();
        }
        self.next_ns = now_ns + PERIOD_NS;
        let (numbers, newest) = (self.incidents.numbers(), self.newest);
        self.newest = numbers.last().copied().unwrap_or(newest).max(newest);
        // One that is just deleted, or of another version, is left out.
        let heads = numbers.into_iter().filter(|number| *number > newest);
        let heads = heads.filter_map(|number| self.incidents.head(number).ok());
        heads.filter(|head| head.run == self.run).collect()
    }
}
