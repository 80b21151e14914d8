//! What the recorder says, told to the person at once and in the summary.

use std::path::Path;

use cell_run::spec::RecordSpec;
use cell_run::summary::RunSummary;

use crate::rundir::RunDir;
use crate::say;

/// Time between two looks at the report (ns).
const PERIOD_NS: u64 = 500_000_000;

/// Looks at the recorder's report.
#[derive(Debug, Default)]
pub(crate) struct RecordWatch {
    next_ns: u64,
    said: Option<String>,
}

impl RecordWatch {
    /// Warns of a new error of the recorder.
    pub(crate) fn turn(&mut self, now_ns: u64, dir: &RunDir) {
        if now_ns < self.next_ns {
            return;
        }
        self.next_ns = now_ns + PERIOD_NS;
        self.say(dir.record_report().and_then(|report| report.error));
    }

    /// After the recorder ended: warns of its error, also in a run without a summary, and adds
    /// the report to the summary.
    pub(crate) fn end(
        &mut self,
        dir: &RunDir,
        spec: &RecordSpec,
        summary: Option<&mut RunSummary>,
    ) {
        let report = dir.record_report();
        let is_closed = report.as_ref().is_some_and(|report| report.closed);
        let mut report = report.unwrap_or_default();
        // A cell that never ran says why, and has no recording.
        if !is_closed
            && let Some(file) = &spec.file
            && (summary.is_some() || file.exists())
        {
            report.error.get_or_insert_with(|| unfinished(file));
        }
        self.say(report.error.clone());
        if let Some(summary) = summary {
            summary.set_record(report);
        }
    }

    fn say(&mut self, error: Option<String>) {
        if let Some(error) = error
            && self.said.as_ref() != Some(&error)
        {
            say::warn(format_args!("recorder: {error}"));
            self.said = Some(error);
        }
    }
}

/// The error of a file that the recorder did not close.
fn unfinished(file: &Path) -> String {
    let show = file.display();
    if file.exists() {
        format!(
            "the recorder ended before it closed {show}: the recording is cut and has no index; the \
             part that it wrote can be read"
        )
    } else {
        format!("the recorder ended before it began {show}")
    }
}

/// Whether what the person asked for is not in the file.
pub fn failed(spec: &RecordSpec, summary: &RunSummary) -> bool {
    spec.file.is_some() && summary.record_error.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_run::record::RecordReport;
    use cell_run::summary::RunFacts;
    use ipc_types::{Decision, Wire, WorldState};

    fn summary() -> RunSummary {
        let facts = RunFacts {
            demo: "reach",
            policy: "follow",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        RunSummary::new(&facts, &WorldState::zeroed(), &Decision::zeroed())
    }

    #[test]
    fn a_recorder_that_was_killed_is_named_where_a_file_was_asked_for() {
        let base = tempfile::tempdir().unwrap();
        let path = base.path().to_owned();
        let dir = RunDir::at(path.clone());
        let mut spec = RecordSpec {
            flight_dir: path.clone(),
            limit_bytes: 1,
            file: None,
        };
        let ended = |spec: &RecordSpec| {
            let mut summary = summary();
            RecordWatch::default().end(&dir, spec, Some(&mut summary));
            (failed(spec, &summary), summary)
        };
        assert!(!ended(&spec).0);
        spec.file = Some(path.join("run.mcap"));
        let (failed, summary) = ended(&spec);
        let error = summary.record_error.unwrap();
        assert!(failed && error.contains("run.mcap"), "{error}");
        let said_without_summary = || {
            let mut watch = RecordWatch::default();
            watch.end(&dir, &spec, None);
            watch.said
        };
        assert_eq!(said_without_summary(), None, "nothing ran");
        std::fs::write(path.join("run.mcap"), "half").unwrap();
        for said in [said_without_summary(), ended(&spec).1.record_error] {
            assert!(said.unwrap().contains("is cut"));
        }
        let mut report = RecordReport {
            gaps: 3,
            bytes: 9,
            error: None,
            closed: true,
            files: vec![path.join("run.mcap"), path.join("run-part2.mcap")],
        };
        report.save(&path).unwrap();
        let (failed, summary) = ended(&spec);
        assert_eq!(
            (failed, summary.record_gaps, summary.record_bytes),
            (false, 3, 9)
        );
        assert_eq!(summary.record_files.len(), 2);
        report.error = Some("No space left on device".to_owned());
        report.save(&path).unwrap();
        assert!(ended(&spec).0);
        std::fs::remove_dir_all(path).unwrap();
    }
}
