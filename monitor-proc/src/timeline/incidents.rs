//! Incidents of the run, which the launcher keeps, for the log and the timeline.

use cell_model::runs::incident::{Head, Incidents};
use cell_model::runs::spec::RunSpec;

/// Interval at which the directory is read (ns).
// A failure is shown within half a second; the directory has 32 entries at most.
const PERIOD_NS: u64 = 500_000_000;

/// Reports each failure of one run once.
pub(crate) struct IncidentWatch {
    incidents: Incidents,
    run: u64,
    newest: u32,
    /// Number of failures of the newest incident that were reported.
    reported: usize,
    next_ns: u64,
}

impl IncidentWatch {
    /// The watch of the run of `spec`; of the incident with number `newest`, `reported` failures
    /// were reported, and of earlier ones all.
    pub(crate) fn new(spec: &RunSpec, newest: u32, reported: usize) -> Self {
        Self {
            incidents: Incidents::at(spec.incidents_dir.clone()),
            run: spec.run,
            newest,
            reported,
            next_ns: 0,
        }
    }

    /// Incidents with new failures, and their descriptions.
    pub(crate) fn take_new(&mut self, now_ns: u64) -> Vec<(Head, String)> {
        if now_ns < self.next_ns {
            return Vec::new();
        }
        self.next_ns = now_ns + PERIOD_NS;
        let mut take_new = Vec::new();
        for number in self.incidents.numbers() {
            // An incident that is just deleted, or of another version, is left out.
            let head = self.incidents.head(number).ok();
            let Some(head) = head.filter(|head| number >= self.newest && head.run == self.run)
            else {
                continue;
            };
            if number > self.newest {
                (self.newest, self.reported) = (number, 0);
            }
            // The launcher adds further failures to an open incident; only those are new.
            let failures = std::iter::once(&head.what).chain(&head.also);
            let new: Vec<String> = failures.skip(self.reported).cloned().collect();
            self.reported += new.len();
            take_new.extend(new.into_iter().map(|what| (head.clone(), what)));
        }
        take_new
    }
}
