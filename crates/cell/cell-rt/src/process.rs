//! Other processes: whether they are alive, what they use, and how they are ended.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

pub use libc::{SIGBUS, SIGCONT, SIGINT, SIGKILL, SIGSTOP, SIGTERM};

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

/// Kills a process of ours and all its descendants, e.g. those of a shell script, so that
/// resources they hold (pipes) become free.
pub fn kill_tree(pid: u32) -> io::Result<()> {
    // One look at all parents before the first kill: an orphan gets another parent.
    let parents: Vec<(u32, u32)> = fs::read_dir("/proc")?
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse().ok())
        .filter_map(|pid| Some((pid, parent_of(pid)?)))
        .collect();
    let mut tree = vec![pid];
    let mut next = 0;
    while let Some(parent) = tree.get(next).copied() {
        let children = parents.iter().filter(|(_, of)| *of == parent);
        tree.extend(children.map(|(child, _)| *child));
        next += 1;
    }
    // The root first, so that it cannot start more.
    let killed = kill(pid, SIGKILL);
    for child in tree.into_iter().skip(1) {
        // It may have ended with its parent.
        kill(child, SIGKILL).ok();
    }
    killed
}

fn parent_of(pid: u32) -> Option<u32> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // Field 4 of the line; the state behind the name is field 3.
    let rest = stat.get(stat.rfind(')')? + 2..)?;
    rest.split(' ').nth(1)?.parse().ok()
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

/// Start of a process in clock ticks since boot; with the id it identifies a process, as ids
/// are reused.
pub fn start_time(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let rest = stat.get(stat.rfind(')')? + 2..)?;
    // Field 22 of the line; the state behind the name is field 3.
    rest.split(' ').nth(19)?.parse().ok()
}

/// Processor time of a thread of a process since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Time on a core (ns).
    pub ran_ns: u64,
    /// Time it could have run and waited for a core (ns); 0 on a kernel that does
    /// not count it.
    pub waited_ns: u64,
    /// Whether it waits now: for a core, or within the kernel for a disk or a page.
    pub waits: bool,
    /// Whether it sleeps now: until a time, or for another thread.
    pub sleeps: bool,
    /// Whether it ended. A process is gone only when all its threads are, which needs a core.
    pub ended: bool,
}

impl Share {
    /// Share of the main thread of the process `pid` now; `None` without such a process.
    pub fn of(pid: u32) -> Option<Self> {
        Self::at(&PathBuf::from(format!("/proc/{pid}")))
    }

    /// Shares of the other threads of the process `pid` now, by id.
    pub fn of_others(pid: u32) -> Vec<(u32, Self)> {
        let threads = fs::read_dir(format!("/proc/{pid}/task"));
        let share = |thread: fs::DirEntry| {
            let id = thread.file_name().to_str()?.parse().ok()?;
            Some((id, (id != pid).then(|| Self::at(&thread.path()))??))
        };
        let threads = threads.into_iter().flatten().flatten();
        threads.filter_map(share).collect()
    }

    fn at(folder: &Path) -> Option<Self> {
        let stat = fs::read_to_string(folder.join("stat")).ok()?;
        let sched = fs::read_to_string(folder.join("schedstat")).unwrap_or_default();
        Self::parse(&stat, &sched)
    }

    fn parse(stat: &str, sched: &str) -> Option<Self> {
        // The command name in parentheses may hold anything, so look behind its end.
        let mut fields = stat.get(stat.rfind(')')? + 2..)?.split(' ');
        let state = fields.next()?;
        // Fields 14 and 15 of the line, in ticks of 10 ms (proc_pid_stat(5)).
        let ticks: u64 = fields.skip(10).take(2).flat_map(str::parse::<u64>).sum();
        let mut counted = sched.split_whitespace().map_while(|n| n.parse().ok());
        let ran_ns: u64 = counted.next().unwrap_or(0);
        Some(Self {
            // Kernels without scheduler statistics give 0: ticks of 10 ms are better than none.
            ran_ns: if ran_ns > 0 {
                ran_ns
            } else {
                ticks * 10_000_000
            },
            waited_ns: counted.next().unwrap_or(0),
            waits: matches!(state, "R" | "D"),
            sleeps: state == "S",
            ended: matches!(state, "Z" | "X"),
        })
    }

    /// Part of the last `elapsed_ns` in which it could not run for lack of a core, a disk or a
    /// page; `before` is from the start of that time.
    ///
    /// The kernel counts the wait for a core. Where it does not (a limit of the control group,
    /// a disk), a process that waits now is taken to have waited all the time it did not run.
    pub fn starved_ns(&self, before: &Self, elapsed_ns: u64) -> u64 {
        let counted = self.waited_ns.saturating_sub(before.waited_ns);
        let ran = self.ran_ns.saturating_sub(before.ran_ns);
        let seen = if self.waits {
            elapsed_ns.saturating_sub(ran)
        } else {
            0
        };
        // Larger of both, as each alone misses one kind of wait;
        // no more than the time that passed.
        counted.max(seen).min(elapsed_ns)
    }
}

/// Those of `paths` that no process has open or mapped. Processes of other users are not
/// visible; they cannot open files of this user.
pub fn unused(mut paths: Vec<PathBuf>) -> Vec<PathBuf> {
    for process in fs::read_dir("/proc").into_iter().flatten().flatten() {
        if paths.is_empty() {
            break;
        }
        let is_process = process.file_name().as_encoded_bytes()[0].is_ascii_digit();
        if is_process {
            retain_unused(&process.path(), &mut paths);
        }
    }
    paths
}

fn retain_unused(process: &Path, paths: &mut Vec<PathBuf>) {
    for file in fs::read_dir(process.join("fd"))
        .into_iter()
        .flatten()
        .flatten()
    {
        if let Ok(target) = fs::read_link(file.path()) {
            paths.retain(|path| *path != target);
        }
    }
    // A mapping outlives its descriptor, so the open files alone are not enough.
    let maps = fs::read(process.join("maps")).unwrap_or_default();
    for line in maps.split(|byte| *byte == b'\n') {
        paths.retain(|path| !line.ends_with(path.as_os_str().as_encoded_bytes()));
    }
}

/// Whether the process `pid` is alive and is the one started at `started` (see [`start_time`]).
pub fn is_same(pid: u32, started: u64) -> bool {
    is_alive(pid) && start_time(pid) == Some(started)
}

/// The kernel's name of a process: of its program, or set by itself.
pub fn name(pid: u32) -> Option<String> {
    let text = fs::read_to_string(format!("/proc/{pid}/comm")).ok()?;
    Some(text.trim_end().to_owned())
}

/// Gives this process a name of up to 15 bytes; called from its main thread.
pub fn rename(name: &str) {
    // A failure leaves the old name.
    fs::write("/proc/self/comm", name).ok();
}

/// Requests `signal` from the kernel when the parent of this process dies, and checks that
/// `expected_parent` has not died before the request.
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
    // Checked after the request: a parent that died before it sends nothing any more.
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
        let started = start_time(own_pid()).unwrap();
        assert!(is_same(own_pid(), started));
        assert!(!is_same(own_pid(), started + 1));
    }

    #[test]
    fn a_process_has_a_name() {
        let program = std::env::current_exe().unwrap();
        let program = program.file_name().unwrap().to_str().unwrap();
        assert!(program.starts_with(&name(own_pid()).unwrap()));
        assert_eq!(name(u32::MAX), None);
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
    fn a_file_is_in_use_while_it_is_open_or_mapped() {
        let path = std::env::temp_dir().join(format!("robocell-used-{}", own_pid()));
        let file = fs::File::create(&path).unwrap();
        assert!(unused(vec![path.clone()]).is_empty());
        drop(file);
        assert_eq!(unused(vec![path.clone()]).len(), 1);
        fs::remove_file(&path).unwrap();
        let program = std::env::current_exe().unwrap();
        assert!(unused(vec![program]).is_empty(), "mapped");
    }

    #[test]
    fn a_process_is_starved_while_it_waits_for_a_core_and_not_while_it_sleeps_or_runs() {
        let stat =
            |state: &str| format!("7 (a) b) {state} 1 7 7 0 -1 4 1 0 0 0 12 3 0 0 20 0 1 0 99");
        let at = |state, sched| Share::parse(&stat(state), sched).unwrap();
        let ms = 1_000_000;
        let before = at("S", "5000000 1000000 9");
        assert_eq!(
            (before.ran_ns, before.waited_ns, before.waits),
            (5 * ms, ms, false)
        );
        // 100 ms later: counted by the kernel, asleep, stopped, in an endless loop,
        // held back by its control group.
        let starved = |state, sched| at(state, sched).starved_ns(&before, 100 * ms) / ms;
        assert_eq!(starved("S", "6000000 91000000 10"), 90);
        assert_eq!(starved("S", "5000000 1000000 9"), 0);
        assert_eq!(starved("T", "5000000 1000000 9"), 0);
        assert_eq!(starved("R", "105000000 1000000 9"), 0);
        assert_eq!(starved("R", "15000000 1000000 9"), 90);
        assert!(at("Z", "6000000 1000000 9").ended && !before.ended);
        assert_eq!(at("R", "0 0 0").ran_ns, 150 * ms, "from the clock ticks");
        assert!(Share::of(own_pid()).unwrap().ran_ns > 0);
        assert_eq!(Share::of(u32::MAX), None);
        // Held within the kernel by a disk.
        assert_eq!(starved("D", "5000000 1000000 9"), 100);
        assert!(before.sleeps && !at("D", "5000000 1000000 9").sleeps);
    }

    #[test]
    fn the_other_threads_of_a_process_are_seen() {
        let (go, wait) = std::sync::mpsc::channel::<()>();
        let (ready, is_ready) = std::sync::mpsc::channel();
        let thread = std::thread::spawn(move || {
            ready.send(()).unwrap();
            wait.recv().ok();
        });
        is_ready.recv().unwrap();
        let others = Share::of_others(own_pid());
        assert!(!others.is_empty());
        assert!(others.iter().all(|(id, _)| *id != own_pid()));
        assert_eq!(Share::of_others(u32::MAX), []);
        drop(go);
        thread.join().unwrap();
    }

    #[test]
    fn a_group_is_never_killed() {
        assert!(kill(0, SIGKILL).is_err());
        assert!(kill(u32::MAX, SIGKILL).is_err());
    }
}
