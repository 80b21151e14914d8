//! Incidents of the run, which the launcher keeps, for the log and the timeline.

use cell_run::incident::{Head, Incidents, STARVED};
use cell_run::spec::RunSpec;
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
        let incidents = Incidents::at(spec.incidents_dir.clone());
        Self::of(incidents, spec.run, newest, reported)
    }

    fn of(incidents: Incidents, run: u64, newest: u32, reported: usize) -> Self {
        Self {
            incidents,
            run,
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
            let failures: Vec<&String> = std::iter::once(&head.what).chain(&head.also).collect();
            let from = std::mem::replace(&mut self.reported, failures.len());
            let (known, new) = failures.split_at(from.min(failures.len()));
            // A busy machine starves all processes at once, which is one event.
            let is_starved = |what: &&&String| what.contains(STARVED);
            let mut starved = known.iter().any(|what| is_starved(&what));
            for what in new {
                let is_repeated = is_starved(&what) && std::mem::replace(&mut starved, true);
                if !is_repeated {
                    take_new.push((head.clone(), (*what).clone()));
                }
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use cell_run::incident::Incident;

    /// An incident of run 7.
    fn incident(also: &[&str], complete: bool) -> Incident {
        Incident {
            head: Head {
                number: 3,
                what: format!("physics {STARVED}"),
                also: also.iter().map(|&what| what.to_owned()).collect(),
                at: String::new(),
                sim_time_s: 1.0,
                run: 7,
                demo: String::new(),
                policy: String::new(),
                seed: 0,
                version: String::new(),
                complete,
            },
            events: Vec::new(),
            loops: Vec::new(),
            logs: Vec::new(),
            recording: std::path::PathBuf::new(),
        }
    }

    #[test]
    fn starvation_is_one_event_and_an_incident_is_taken_whole_once() {
        let dir = tempfile::tempdir().unwrap();
        let incidents = Incidents::at(dir.path().to_owned());
        let mut watch = IncidentWatch::of(incidents.clone(), 7, 0, 0);
        let starved = format!("task {STARVED}");
        let texts = |watch: &mut IncidentWatch| -> Vec<String> {
            watch.take_new().into_iter().map(|(_, what)| what).collect()
        };
        incidents.save(&incident(&[], false)).unwrap();
        assert_eq!(texts(&mut watch), [format!("physics {STARVED}")]);
        let also = [starved.as_str(), "task was killed (SIGKILL)"];
        incidents.save(&incident(&also, false)).unwrap();
        assert_eq!(texts(&mut watch), ["task was killed (SIGKILL)"]);
        assert!(watch.take_whole(false).is_empty());
        incidents.save(&incident(&also, true)).unwrap();
        assert!(texts(&mut watch).is_empty());
        let whole = watch.take_whole(false);
        assert_eq!(whole[0]["also"], json!(also));
        assert!(watch.take_whole(true).is_empty());
    }
}
