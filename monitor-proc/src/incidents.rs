//! Incidents of the run, which the launcher keeps, for the log and the timeline.

use cell_model::runs::incident::{Head, Incidents};
use cell_model::runs::spec::RunSpec;

/// How often the directory is looked at (ns).
const PERIOD_NS: u64 = 500_000_000;

/// Tells each failure of one run once.
pub(crate) struct IncidentWatch {
    incidents: Incidents,
    run: u64,
    newest: u32,
    /// Failures of the newest that were told.
    told: usize,
    next_ns: u64,
}

impl IncidentWatch {
    /// Of the run of `spec`; of the incident with number `newest`, `told` failures were
    /// told, and of those before it all.
    pub(crate) fn new(spec: &RunSpec, newest: u32, told: usize) -> Self {
        Self {
            incidents: Incidents::at(spec.incidents_dir.clone()),
            run: spec.run,
            newest,
            told,
            next_ns: 0,
        }
    }

    /// Incidents with failures that are new, and what failed.
    pub(crate) fn news(&mut self, now_ns: u64) -> Vec<(Head, String)> {
        if now_ns < self.next_ns {
            return Vec::new();
        }
        self.next_ns = now_ns + PERIOD_NS;
        let mut news = Vec::new();
        for number in self.incidents.numbers() {
            // One that is just deleted, or of another version, is left out.
            let head = self.incidents.head(number).ok();
            let Some(head) = head.filter(|head| number >= self.newest && head.run == self.run)
            else {
                continue;
            };
            if number > self.newest {
                (self.newest, self.told) = (number, 0);
            }
            let failures = std::iter::once(&head.what).chain(&head.also);
            let new: Vec<String> = failures.skip(self.told).cloned().collect();
            self.told += new.len();
            news.extend(new.into_iter().map(|what| (head.clone(), what)));
        }
        news
    }
}
