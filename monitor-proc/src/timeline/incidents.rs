//! Incidents of the run, which the launcher keeps, for the log and the timeline.

use cell_model::runs::incident::{Head, Incidents};
use cell_model::runs::spec::RunSpec;
use serde_json::{Value, json};

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
    /// Reported incidents that were not taken whole yet.
    waiting: Vec<u32>,
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
            // The newest may have been incomplete when the monitor ended.
            waiting: (newest > 0).then_some(newest).into_iter().collect(),
            next_ns: 0,
        }
    }

    /// Whether the directory is to be read at `now_ns`.
    pub(crate) fn is_due(&mut self, now_ns: u64) -> bool {
        let is_due = now_ns >= self.next_ns;
        if is_due {
            self.next_ns = now_ns + PERIOD_NS;
        }
        is_due
    }

    /// Incidents with new failures, and their descriptions.
    pub(crate) fn take_new(&mut self) -> Vec<(Head, String)> {
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
                self.waiting.push(number);
            }
            // The launcher adds further failures to an open incident; only those are new.
            let failures = std::iter::once(&head.what).chain(&head.also);
            let new: Vec<String> = failures.skip(self.reported).cloned().collect();
            self.reported += new.len();
            take_new.extend(new.into_iter().map(|what| (head.clone(), what)));
        }
        take_new
    }

    /// The reported incidents that were not taken yet, as JSON: those that are complete, or at the
    /// end of the run all.
    pub(crate) fn take_whole(&mut self, at_end: bool) -> Vec<Value> {
        let mut whole = Vec::new();
        self.waiting.retain(|number| {
            let Ok(incident) = self.incidents.load(*number) else {
                // Deleted, or of another version.
                return false;
            };
            let is_taken = incident.head.complete || at_end;
            if is_taken {
                whole.push(json!(incident));
            }
            !is_taken
        });
        whole
    }
}
