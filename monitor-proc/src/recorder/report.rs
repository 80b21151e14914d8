//! What the launcher is told of the recording.

use std::path::{Path, PathBuf};

use cell_model::runs::record::RecordReport;

/// Keeps the report in the run directory up to date.
pub(super) struct Report {
    dir: PathBuf,
    /// Of the starts of this process before this one.
    before: RecordReport,
    written: Option<RecordReport>,
}

impl Report {
    pub(super) fn new(dir: &Path, generation: u32) -> Self {
        let before = RecordReport::load(dir).filter(|_| generation > 1);
        Self {
            dir: dir.to_owned(),
            before: before.unwrap_or_default(),
            written: None,
        }
    }

    /// Writes what is `now` of this start of the process, if people should know.
    pub(super) fn write(&mut self, now: RecordReport) {
        let report = RecordReport {
            gaps: self.before.gaps + now.gaps,
            bytes: self.before.bytes + now.bytes,
            error: now.error.or_else(|| self.before.error.clone()),
            closed: now.closed,
        };
        let is_news = self.written.as_ref().is_none_or(|written| {
            written.error != report.error || written.gaps != report.gaps || report.closed
        });
        if is_news {
            // Without it the launcher says that there is no report.
            let _written = report.save(&self.dir).is_ok();
            self.written = Some(report);
        }
    }
}
