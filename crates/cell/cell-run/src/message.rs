//! The reason for which a task failed, or its newest fault, in one sentence. It is kept over
//! restarts of the task, and passed from the task to the summary of the run.

use std::io;
use std::path::{Path, PathBuf};

/// The sentence in force.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message(Option<String>);

impl Message {
    /// The sentence of the run in `dir`, if its task has one.
    pub fn load(dir: &Path) -> Self {
        Self(std::fs::read_to_string(path(dir)).ok())
    }

    /// Writes the sentence; it can be read at any time.
    ///
    /// # Errors
    /// Returns errors of the file system.
    pub fn save(&self, dir: &Path) -> io::Result<()> {
        match &self.0 {
            Some(text) => cell_model::draft::replace_unsynced(&path(dir), text.as_bytes(), 0o644),
            // Removed, not emptied: `load` takes every file for a sentence.
            None => match std::fs::remove_file(path(dir)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
                _ => Ok(()),
            },
        }
    }

    /// Takes the sentence of a task after a decision; returns whether it changed. A task that
    /// was restarted knows from its checkpoint that it has failed, but not the reason.
    pub fn update(&mut self, said: Option<&str>, has_failed: bool) -> bool {
        // The reason of the former start is kept: a restarted task has none, and would clear
        // it.
        if said == self.0.as_deref() || (said.is_none() && has_failed) {
            return false;
        }
        self.0 = said.map(str::to_owned);
        true
    }

    /// The sentence.
    pub fn text(&self) -> Option<&str> {
        self.0.as_deref()
    }
}

fn path(dir: &Path) -> PathBuf {
    dir.join("message.txt")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_of_a_task_that_failed_keeps_why_and_a_new_begin_forgets_it() {
        let dir = tempfile::tempdir().unwrap();
        let mut message = Message::load(dir.path());
        assert!(message.update(Some("red_cube cannot be gripped"), true));
        message.save(dir.path()).unwrap();
        let mut restarted = Message::load(dir.path());
        assert!(!restarted.update(None, true));
        assert_eq!(restarted, message);
        assert!(restarted.update(None, false));
        restarted.save(dir.path()).unwrap();
        assert_eq!(Message::load(dir.path()).text(), None);
    }
}
