//! The last act of a process whose launcher was killed: no other process is left to end a
//! process of the cell that is stopped or hangs.

use std::path::Path;
use std::time::Duration;

use cell_model::runs::children::ChildId;
use cell_rt::process::{self, SIGCONT, SIGKILL};

/// Name of a process that waits here: it is not waited for.
const NAME: &str = "orphan";
/// A process that ends in order has ended after this.
const LIMIT: Duration = Duration::from_secs(3);
/// Time between two looks.
const PAUSE: Duration = Duration::from_millis(10);

/// Wakes the other processes of the run in `run_dir`, which were told to end when the
/// launcher died, and kills those that do not.
pub(crate) fn end_the_others(run_dir: &Path) {
    process::rename(NAME);
    let mut others = ChildId::all(run_dir);
    others.retain(|other| other.pid != process::own_pid());
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
    signal(&others, SIGCONT);
    for _ in 0..LIMIT.as_millis() / PAUSE.as_millis() {
        others.retain(remains);
        if others.is_empty() {
            return;
        }
        std::thread::sleep(PAUSE);
    }
    others.retain(remains);
    signal(&others, SIGKILL);
}
