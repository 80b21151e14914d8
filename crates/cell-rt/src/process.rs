//! Other processes: are they alive, end them, end with them.

use std::io;

pub use libc::{SIGCONT, SIGINT, SIGKILL, SIGSTOP, SIGTERM};

/// Own process id.
pub fn own_pid() -> u32 {
    std::process::id()
}

fn checked_pid(pid: u32) -> io::Result<libc::pid_t> {
    // 0 and negative ids address groups of processes, never one.
    match libc::pid_t::try_from(pid) {
        Ok(pid) if pid > 0 => Ok(pid),
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("{pid} is not a process id"),
        )),
    }
}

/// Sends `signal` to one process. Errors: no such process, not ours, or an id
/// that would address a group.
pub fn kill(pid: u32, signal: i32) -> io::Result<()> {
    let pid = checked_pid(pid)?;
    // SAFETY: kill takes two integers; the id is positive, so it names one
    // process.
    if unsafe { libc::kill(pid, signal) } == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

/// Whether a process of this id exists. One that ended but was not waited for
/// by its parent (a zombie) counts as dead.
pub fn is_alive(pid: u32) -> bool {
    if checked_pid(pid).is_err() {
        return false;
    }
    let Ok(stat) = std::fs::read_to_string(format!("/proc/{pid}/stat")) else {
        return false;
    };
    // The command name in parentheses may hold anything, so look behind its end.
    let state = stat.rfind(')').and_then(|end| stat.get(end + 2..end + 3));
    !matches!(state, Some("Z" | "X"))
}

/// Start of a process in clock ticks since boot; with the id it names a process
/// for good, as ids are used again.
pub fn start_time(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let rest = stat.get(stat.rfind(')')? + 2..)?;
    // Field 22 of the line; the state behind the name is field 3.
    rest.split(' ').nth(19)?.parse().ok()
}

/// Asks the kernel to send `signal` to this process when its parent dies, and
/// checks that the parent `expected_parent` has not died before the request.
///
/// The kernel ties this to the *thread* that started the process: a parent
/// must start its children from a thread that lives as long as itself, which
/// means from its main thread.
///
/// Returns whether the parent is still there.
pub fn die_with_parent(signal: i32, expected_parent: u32) -> io::Result<bool> {
    // SAFETY: PR_SET_PDEATHSIG takes an integer and touches no memory.
    if unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, signal) } != 0 {
        return Err(io::Error::last_os_error());
    }
    Ok(parent_pid() == expected_parent)
}

/// Id of the parent process; changes when the parent dies.
pub fn parent_pid() -> u32 {
    // SAFETY: getppid has no arguments and cannot fail.
    unsafe { libc::getppid() }.unsigned_abs()
}

/// Own user id.
pub fn user_id() -> u32 {
    // SAFETY: getuid has no arguments and cannot fail.
    unsafe { libc::getuid() }
}

/// Files created from now on are for this user only.
pub fn private_umask() {
    // SAFETY: umask takes an integer and cannot fail.
    unsafe { libc::umask(0o077) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn we_are_alive_and_started_once() {
        assert!(is_alive(own_pid()));
        assert_eq!(start_time(own_pid()), start_time(own_pid()));
        assert!(start_time(own_pid()).is_some());
    }

    #[test]
    fn a_killed_child_is_dead_before_it_is_waited_for() {
        let mut child = std::process::Command::new("sleep")
            .arg("100")
            .spawn()
            .unwrap();
        assert!(is_alive(child.id()));
        kill(child.id(), SIGKILL).unwrap();
        while is_alive(child.id()) {
            std::thread::yield_now();
        }
        child.wait().unwrap();
        assert!(!is_alive(child.id()));
    }

    #[test]
    fn a_group_is_never_killed() {
        assert!(kill(0, SIGKILL).is_err());
        assert!(kill(u32::MAX, SIGKILL).is_err());
    }
}
