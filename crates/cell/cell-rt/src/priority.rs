//! Requests real-time scheduling and reports exactly what was granted.

use std::io;

/// `SCHED_FIFO` priority of physics.
// Highest: all others wait for the state.
pub const PHYSICS_PRIORITY: i32 = 80;
/// `SCHED_FIFO` priority of a controller.
// Below physics, as a command can only follow a state.
pub const CONTROLLER_PRIORITY: i32 = 75;

/// `SCHED_FIFO` priority of a task: above everything but the loops of the cell, so that a busy
/// machine stops no decision.
pub const TASK_PRIORITY: i32 = 70;

/// `SCHED_FIFO` priority of a launcher while its cell runs: it only looks, and a process that
/// was killed on a busy machine has to be back soon.
pub const LAUNCHER_PRIORITY: i32 = 65;

/// Result of a request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Granted {
    /// `SCHED_FIFO` was granted.
    pub fifo: bool,
    /// All memory is locked.
    pub memory_locked: bool,
    /// Pinned to this core.
    pub core: Option<usize>,
    /// What was refused and what to do, one line each.
    pub refused: Vec<String>,
}

/// Requests everything a 1 kHz loop wants: `SCHED_FIFO` at `priority`, the core `core` (`None`:
/// any), locked memory, timer slack of 1 ns. Never fails: refusals are in the result.
pub fn request(priority: i32, core: Option<usize>) -> Granted {
    let mut granted = Granted::default();
    // Without this every sleep of a normal thread ends 50 µs late.
    if let Err(error) = set_timer_slack_ns(1) {
        granted
            .refused
            .push(format!("timer slack of 1 ns: {error}"));
    }
    match set_fifo(priority) {
        Ok(()) => granted.fifo = true,
        Err(error) => granted.refused.push(format!(
            "SCHED_FIFO {priority}: {error}; allow it with `ulimit -r 90` or \
             `@USER - rtprio 90` in /etc/security/limits.conf"
        )),
    }
    match crate::memory::lock_all() {
        Ok(()) => granted.memory_locked = true,
        Err(error) => granted.refused.push(format!(
            "locked memory: {error}; allow it with `ulimit -l unlimited` or \
             `@USER - memlock unlimited` in /etc/security/limits.conf"
        )),
    }
    if let Some(core) = core {
        match pin_to_core(core) {
            Ok(()) => granted.core = Some(core),
            Err(error) => granted.refused.push(format!("core {core}: {error}")),
        }
    }
    // Also without locked memory: both remove page faults from the cycle.
    crate::memory::keep_heap();
    crate::memory::prefault_stack();
    granted
}

/// Puts the calling thread into `SCHED_FIFO` at `priority` (1 to 99). Threads and
/// processes it starts are of the normal class.
pub fn set_fifo(priority: i32) -> io::Result<()> {
    let param = libc::sched_param {
        sched_priority: priority,
    };
    // Children start in the normal class: a program started from a loop must not block a core.
    let policy = libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK;
    // SAFETY: the pointer is to a live parameter; 0 names the calling thread.
    check(unsafe { libc::sched_setscheduler(0, policy, &raw const param) })
}

/// Puts the calling thread back into the normal class.
pub fn set_other() -> io::Result<()> {
    let param = libc::sched_param { sched_priority: 0 };
    // SAFETY: the pointer is to a live parameter; 0 names the calling thread.
    check(unsafe { libc::sched_setscheduler(0, libc::SCHED_OTHER, &raw const param) })
}

/// Whether the calling thread may ask for `SCHED_FIFO` at `priority`; puts it
/// back afterwards.
pub fn probe_fifo(priority: i32) -> bool {
    set_fifo(priority).is_ok() && set_other().is_ok()
}

/// Keeps the calling thread, and threads it starts, on one core.
pub fn pin_to_core(core: usize) -> io::Result<()> {
    if core >= 8 * size_of::<libc::cpu_set_t>() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "no such core"));
    }
    // SAFETY: cpu_set_t is plain data, all zeros is the empty set.
    let mut set: libc::cpu_set_t = unsafe { core::mem::zeroed() };
    // SAFETY: `core` is within the set (checked above).
    unsafe { libc::CPU_SET(core, &mut set) };
    // SAFETY: the pointer is to a live set of the given size; 0 names the
    // calling thread.
    check(unsafe { libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &raw const set) })
}

/// Cores this process may use.
pub fn core_count() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

fn set_timer_slack_ns(slack: libc::c_ulong) -> io::Result<()> {
    // SAFETY: PR_SET_TIMERSLACK takes an integer and touches no memory.
    check(unsafe { libc::prctl(libc::PR_SET_TIMERSLACK, slack) })
}

fn check(result: libc::c_int) -> io::Result<()> {
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_refused_is_said() {
        let granted = request(PHYSICS_PRIORITY, Some(0));
        assert_eq!(
            granted.fifo,
            !granted
                .refused
                .iter()
                .any(|line| line.contains("SCHED_FIFO"))
        );
        set_other().unwrap();
    }

    #[test]
    fn a_core_that_does_not_exist_is_an_error() {
        assert!(pin_to_core(usize::MAX).is_err());
        assert!(pin_to_core(1023).is_err());
    }
}
