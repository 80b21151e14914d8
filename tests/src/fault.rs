//! What a test does to a cell.

use cell_rt::process::{SIGKILL, SIGSTOP, kill};

use crate::cell::{TestCell, generation, pid};

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
