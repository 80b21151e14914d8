//! Where the flight recorder keeps its ring, and the launcher incidents.

use std::path::PathBuf;

use cell_run::spec::RecordSpec;

use crate::rundir::{ENV_RUN_DIR, RunDir};

/// Names the directory of the recordings of all cells.
const ENV_STATE_DIR: &str = "ROBOCELL_STATE_DIR";
/// Bytes of the ring on a disk: ten minutes and more, also of two arms that work
/// once (1.8 MB a second) and rest (0.7), and of one that works all the time (0.9).
const DISK_BYTES: u64 = 640 << 20;
/// Bytes of the ring in memory.
const MEMORY_BYTES: u64 = 96 << 20;

/// The ring of `cell`.
pub fn ring(cell: &str, dir: &RunDir) -> RecordSpec {
    match state_dir() {
        Some(state) => RecordSpec {
            flight_dir: state.join("flight").join(cell),
            limit_bytes: DISK_BYTES,
            file: None,
        },
        None => RecordSpec {
            flight_dir: dir.path().join("flight"),
            limit_bytes: MEMORY_BYTES,
            file: None,
        },
    }
}

/// The incidents of `cell`.
pub fn incidents(cell: &str, dir: &RunDir) -> PathBuf {
    state_dir().map_or_else(
        || dir.path().join("incidents"),
        |state| state.join("incidents").join(cell),
    )
}

/// On disk where the user keeps such things. With another run directory, or without a
/// home, there is none: the run directory, which is in memory, is used.
fn state_dir() -> Option<PathBuf> {
    let get = |name: &str| std::env::var_os(name);
    let is_set = |name: &str| get(name).is_some_and(|value| !value.is_empty());
    if !is_set(ENV_STATE_DIR) && is_set(ENV_RUN_DIR) {
        return None;
    }
    cell_rt::user_dir(get, ENV_STATE_DIR, "XDG_STATE_HOME", ".local/state")
}
