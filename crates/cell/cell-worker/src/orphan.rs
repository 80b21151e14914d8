//! Ends the rest of the cell after the launcher was killed: a process that is stopped or hangs
//! cannot end itself, and its supervisor is gone.

use std::path::Path;
use std::time::Duration;

use cell_rt::process::{self, SIGCONT, SIGKILL};
use cell_run::children::ChildId;

/// Name of a process that waits here; such processes do not wait for each other.
const NAME: &str = "orphan";
/// Time in which a process that ends in order has ended.
// Killed too early, a recorder leaves a file without its index.
const LIMIT: Duration = Duration::from_secs(3);
/// Interval between two checks.
const PAUSE: Duration = Duration::from_millis(10);

/// Resumes the other processes of the run in `run_dir`, which received SIGTERM when the
/// launcher died, and kills those that do not end.
pub(crate) fn end_the_others(run_dir: &Path) {
    // All survivors arrive here at about the same time; by this name they recognise each other.
    process::rename(NAME);
    let mut others = ChildId::all(run_dir);
    others.retain(|other| other.pid != process::own_pid());
    // Compared with the start time: an id may belong to another program by now.
    let remains = |other: &ChildId| {
        process::is_same(other.pid, other.started)
            && process::name(other.pid).as_deref() != Some(NAME)
    };
    let signal = |others: &[ChildId], signal| {
        for other in others {
            // It may have ended a moment ago.
            process::kill(other.pid, signal).ok();
        }
    };
    others.retain(remains);
    // A stopped process gets its SIGTERM only once it is continued.
    signal(&others, SIGCONT);
    for _ in 0..LIMIT.as_millis() / PAUSE.as_millis() {
        others.retain(remains);
        if others.is_empty() {
            return;
        }
        std::thread::sleep(PAUSE);
    }
    // Checked once more right before the kill, as ids are used again.
    others.retain(remains);
    signal(&others, SIGKILL);
}
