//! Report of the recording for the launcher.

use std::path::{Path, PathBuf};

use cell_run::record::RecordReport;

/// Keeps the report in the run directory up to date.
pub(super) struct Report {
    dir: PathBuf,
    /// Sum of the earlier starts of this process.
    before: RecordReport,
    written: Option<RecordReport>,
}

impl Report {
    pub(super) fn new(dir: &Path, generation: u32) -> Self {
        let before = RecordReport::load(dir).filter(|_| generation > 1);
        // Only a later start: the first one must not add a report of another run.
        let mut before = before.unwrap_or_default();
        // A process that was killed could not write the final size of its file.
        let bytes = |file: &PathBuf| file.metadata().map_or(0, |meta| meta.len());
        let on_disk = before.files.iter().map(bytes).sum();
        before.bytes = before.bytes.max(on_disk);
        Self {
            dir: dir.to_owned(),
            before,
            written: None,
        }
    }

    /// Writes the report `now` of this start of the process, if it has changes for people.
    pub(super) fn write(&mut self, now: RecordReport) {
        let report = RecordReport {
            gaps: self.before.gaps + now.gaps,
            bytes: self.before.bytes + now.bytes,
            error: now.error.or_else(|| self.before.error.clone()),
            closed: now.closed,
            files: [&self.before.files[..], &now.files].concat(),
        };
        // The size changes all the time and is read from the disk; it is not a change.
        let is_changed = self.written.as_ref().is_none_or(|written| {
            written.error != report.error
                || written.gaps != report.gaps
                || written.files != report.files
                || report.closed
        });
        if is_changed {
            // Without it the launcher reports that there is no report.
            let _written = report.save(&self.dir).is_ok();
            self.written = Some(report);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recorder_that_was_killed_leaves_its_part_in_the_report_of_the_next() {
        let dir = tempfile::tempdir().unwrap();
        let files = ["run.mcap", "run-part2.mcap"].map(|name| dir.path().join(name));
        let of = |file: &PathBuf| RecordReport {
            files: vec![file.clone()],
            ..RecordReport::default()
        };
        Report::new(dir.path(), 1).write(of(&files[0]));
        std::fs::write(&files[0], [0; 7]).unwrap();
        let mut second = Report::new(dir.path(), 2);
        second.write(of(&files[1]));
        let closed = RecordReport {
            bytes: 5,
            closed: true,
            ..of(&files[1])
        };
        second.write(closed);
        let report = RecordReport::load(dir.path()).unwrap();
        assert_eq!((&report.files[..], report.bytes), (&files[..], 12));
        assert!(report.closed);
    }
}
