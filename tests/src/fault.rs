//! What a test does to a cell.

use std::fs::{self, OpenOptions};
use std::os::unix::fs::OpenOptionsExt;
use std::path::PathBuf;

use cell_rt::process::{SIGKILL, SIGSTOP, is_alive, kill};

use crate::assert::{prefix, segments};
use crate::cell::{TestCell, generation, pid};
use crate::program::wait_for;

/// Kills the process `name` with SIGKILL and waits for the next start of it.
///
/// # Panics
/// Where there is no such process.
pub fn kill_and_wait(cell: &TestCell, name: &str) {
    let status = cell.wait_up();
    let before = generation(&status, name);
    kill(pid(&status, name), SIGKILL).expect("it can be killed");
    cell.wait_status("a new start", |status| generation(status, name) > before);
}

/// Stops the process `name` with SIGSTOP and waits for its replacement.
///
/// # Panics
/// Where there is no such process.
pub fn freeze_and_wait(cell: &TestCell, name: &str) {
    let status = cell.wait_up();
    let before = generation(&status, name);
    kill(pid(&status, name), SIGSTOP).expect("it can be stopped");
    cell.wait_status("a new start", |status| generation(status, name) > before);
}

/// Kills the process `name`, and leaves what kill -9 leaves in the middle of the
/// creation of its connections: segments of size 0 that no process may read. The launcher
/// has to be stopped, so that it has cleaned up nothing. How many there are.
///
/// # Panics
/// Where there is no such process.
pub fn kill_in_creation(cell: &TestCell, name: &str) -> usize {
    let status = cell.wait_up();
    let dying = pid(&status, name);
    let maps = |pid| fs::read_to_string(format!("/proc/{pid}/maps")).unwrap_or_default();
    let its_maps = maps(dying);
    kill(dying, SIGKILL).expect("it can be killed");
    wait_for("its end", || (!is_alive(dying)).then_some(()));
    let mut forged = 0;
    for segment in segments(&prefix(&cell.run_dir())) {
        if segment.ends_with(".connection") && its_maps.contains(&segment) {
            let path = PathBuf::from("/dev/shm").join(segment);
            fs::remove_file(&path).expect("a segment");
            let mut options = OpenOptions::new();
            let empty = options.write(true).create_new(true).mode(0o200).open(&path);
            empty.expect("an empty segment");
            forged += 1;
        }
    }
    forged
}
