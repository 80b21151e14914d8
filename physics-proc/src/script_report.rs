//! Replies to the lines of the script, in a file of the run directory for the summary.

use std::path::Path;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;

use cell_run::script_report::{ScriptReply, save};

use crate::plant::Plant;

/// Replies on their way to the file.
// A full channel loses nothing: the whole list is sent again with the next tick.
const WAITING: usize = 4;

/// Writes the replies when there are new ones. Writing is left to a thread: it takes
/// longer than a tick.
pub(crate) struct ScriptReport {
    replies: Option<SyncSender<Vec<ScriptReply>>>,
    writer: Option<JoinHandle<()>>,
    /// Replies the thread has.
    sent: usize,
}

impl ScriptReport {
    pub(crate) fn new(run_dir: &Path) -> Self {
        let (replies, to_write) = sync_channel::<Vec<ScriptReply>>(WAITING);
        let run_dir = run_dir.to_owned();
        let work = move || {
            for replies in to_write {
                if let Err(error) = save(&replies, &run_dir) {
                    cell_worker::warn(format_args!(
                        "the replies to the script are not kept: {error}"
                    ));
                }
            }
        };
        let thread = std::thread::Builder::new().name("script".to_owned());
        let writer = thread.spawn(work).ok();
        Self {
            replies: writer.is_some().then_some(replies),
            writer,
            sent: 0,
        }
    }

    /// That of a model, which keeps no replies.
    pub(crate) fn none() -> Self {
        Self {
            replies: None,
            writer: None,
            sent: 0,
        }
    }

    /// Hands new replies to the thread. A full channel is tried again at the next call.
    pub(crate) fn send_new(&mut self, plant: &Plant) {
        let replies = plant.script_replies();
        // Fewer: physics resumed from a state before the last ones.
        if replies.len() == self.sent {
            return;
        }
        let taken = self
            .replies
            .as_ref()
            .is_some_and(|thread| thread.try_send(replies.to_vec()).is_ok());
        if taken {
            self.sent = replies.len();
        }
    }
}

impl Drop for ScriptReport {
    fn drop(&mut self) {
        // Closes the channel, which ends the thread; joining before that would wait for ever.
        self.replies = None;
        if let Some(writer) = self.writer.take() {
            // The thread has no result.
            let _ended = writer.join().is_ok();
        }
    }
}
