//! The reason of a failed task, in a file of the run directory for the summary.

use std::path::{Path, PathBuf};

use cell_run::message::Message;
use robocell_task::Task;

/// A fault with a changing text is written at most once in so many decisions.
// Once a second at 100 decisions a second: a text with a number in it changes with every
// decision, and each write replaces a file.
const PERIOD: u32 = 100;

/// Keeps the file of the run equal to the message of the task.
pub(crate) struct MessageFile {
    dir: PathBuf,
    message: Message,
    is_written: bool,
    /// Decisions until it may be written again.
    wait: u32,
}

impl MessageFile {
    /// Continues the file of the run in `dir`.
    pub(crate) fn open(dir: &Path) -> Self {
        Self {
            dir: dir.to_owned(),
            message: Message::load(dir),
            is_written: true,
            wait: 0,
        }
    }

    /// To be called after each decision, before it is published: a run ends with the
    /// decision that reports the failure of its job.
    pub(crate) fn decided(&mut self, task: &Task) {
        let has_failed = task.has_failed();
        self.is_written &= !self.message.update(task.message(), has_failed);
        self.wait = self.wait.saturating_sub(1);
        // The reason of a failure is written at once: the launcher reads the file as soon as
        // the run has ended.
        if !self.is_written && (has_failed || self.wait == 0) {
            self.write();
        }
    }

    /// To be called at the end of the process: writes a change that waited for its turn.
    pub(crate) fn end(&mut self) {
        if !self.is_written {
            self.write();
        }
    }

    fn write(&mut self) {
        (self.is_written, self.wait) = (true, PERIOD);
        if let Err(error) = self.message.save(&self.dir) {
            cell_worker::warn(format_args!(
                "why the task failed is not in the summary: {error}"
            ));
        }
    }
}

#[cfg(test)]
mod tests;
