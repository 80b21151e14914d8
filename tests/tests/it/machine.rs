//! A machine on a bad day: its clock jumps, its shared memory is full, everything is
//! started at once.

use std::path::Path;
use std::process::{Command, Stdio};

use robocell_tests::cell::base;
use robocell_tests::program::{built, finish, robocell, wait_for};

/// Starts of one cell at the same time.
const STARTS: usize = 12;

#[test]
fn of_many_starts_at_once_exactly_one_wins_and_the_others_name_it() {
    let base = base();
    let start = |_| {
        let mut command = robocell(
            base.path(),
            &["run", "franka-stack", "--headless", "--paused"],
        );
        let piped = command.stdout(Stdio::null()).stderr(Stdio::piped());
        piped.spawn().unwrap()
    };
    let mut running: Vec<_> = (0..STARTS).map(start).collect();
    let mut refused = Vec::new();
    wait_for("all but one to end", || {
        let ended = |child: &mut std::process::Child| matches!(child.try_wait(), Ok(Some(_)));
        let at = running.iter_mut().position(ended);
        refused.extend(at.map(|at| running.remove(at)));
        (running.len() == 1).then_some(())
    });
    let winner = running[0].id().to_string();
    for child in refused {
        let said = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(said.status.code(), Some(3), "{text}");
        assert!(text.contains("is running already"), "{text}");
        assert!(text.contains(&winner), "{winner}: {text}");
    }
    // It may still be starting.
    wait_for("its answer", || {
        (finish(robocell(base.path(), &["down"])).code == 0).then_some(())
    });
    assert!(running[0].wait().unwrap().success());
}

/// A library that moves the wall clock by an hour, forth and back, every second.
const JUMPING: &str = r"
#define _GNU_SOURCE
#include <time.h>
#include <sys/syscall.h>
#include <unistd.h>
int clock_gettime(clockid_t id, struct timespec *now) {
    int failed = syscall(SYS_clock_gettime, id, now);
    if (id == CLOCK_REALTIME && !failed) now->tv_sec += now->tv_sec % 2 ? 3600 : -3600;
    return failed;
}
";

/// The wall clock of `launcher` and task jumps; false where that cannot be done here.
fn with_jumping_clock(dir: &Path, command: &mut Command) -> bool {
    let (source, library) = (dir.join("jump.c"), dir.join("jump.so"));
    std::fs::write(&source, JUMPING).unwrap();
    let mut compiler = Command::new("cc");
    compiler
        .args(["-shared", "-fPIC", "-o"])
        .args([&library, &source]);
    if !compiler.status().is_ok_and(|status| status.success()) {
        return false;
    }
    let second = |jumps: bool| {
        let mut date = Command::new("date");
        date.arg("+%s");
        if jumps {
            date.env("LD_PRELOAD", &library);
        }
        finish(date).stdout.trim().parse::<i64>().unwrap()
    };
    command.env("LD_PRELOAD", &library);
    (second(true) - second(false)).abs() > 3_000
}

#[test]
fn a_wall_clock_that_jumps_by_hours_changes_nothing() {
    let base = base();
    let task = built("task-proc");
    let arguments = [
        "run",
        "franka-stack",
        "--headless",
        "--timeout",
        "4",
        "--json",
    ];
    let mut command = robocell(base.path(), &arguments);
    // A program of the user's own gets all of the user's environment.
    command.args(["--task", task.to_str().unwrap()]);
    if !with_jumping_clock(base.path(), &mut command) {
        eprintln!("skipped: no C compiler, or programs here do not use its library");
        return;
    }
    let said = finish(command);
    let summary = said.json();
    assert_eq!(summary["ticks"], 4_000, "{summary}");
    assert_eq!(summary["task_restarts"], 0, "{summary}");
    assert_eq!(summary["limit_violations"], 0, "{summary}");
    assert!(!said.stderr.contains("started again"), "{}", said.stderr);
}

#[test]
fn full_shared_memory_ends_no_run_and_processes_come_back_when_there_is_room() {
    let program = built("robocell");
    // A file system of our own in the place of /dev/shm, for these processes alone.
    let script = format!(
        "mount -t tmpfs -o size=160m tmpfs /dev/shm && exec {} chaos franka-stack --json \
         --faults fill,kill --rate 120 --seed 2 --minutes 0.2",
        program.display()
    );
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &script]);
    command
        .env_remove("ROBOCELL_RUN_DIR")
        .env_remove("XDG_RUNTIME_DIR");
    command.env("ROBOCELL_STATE_DIR", base().path());
    let allowed = Command::new("unshare").args(["-m", "true"]).status();
    if !allowed.is_ok_and(|status| status.success()) {
        eprintln!("skipped: a mount namespace is for root");
        return;
    }
    let said = finish(command);
    let report = said.json();
    let count = |kind: &str| report["faults"][kind].as_u64().unwrap();
    assert!(count("fill") > 2 && count("kill") > 2, "{report}");
    for what in ["jobs_failed", "parts_lost", "limit_violations", "leftovers"] {
        assert_eq!(report[what], 0, "{report} {}", said.stderr);
    }
    assert!(
        said.stderr.contains("started again when there is room"),
        "{}",
        said.stderr
    );
}

#[test]
fn full_shared_memory_is_named_by_every_command_that_joins_a_cell() {
    let program = built("robocell");
    // As above; the commands run while all of it is in use, as the last of them says.
    let script = format!(
        "mount -t tmpfs -o size=160m tmpfs /dev/shm || exit 9; R={}
         $R run cube --headless --paused >/dev/null 2>&1 & L=$!
         for i in $(seq 600); do $R status >/dev/null 2>&1 && break; sleep 0.1; done
         dd if=/dev/zero of=/dev/shm/fill bs=4k 2>/dev/null
         for c in status pause top; do $R $c; echo code $?; done
         $R down; wait $L",
        program.display()
    );
    let mut command = Command::new("unshare");
    command.args(["-m", "sh", "-c", &script]);
    command
        .env_remove("ROBOCELL_RUN_DIR")
        .env_remove("XDG_RUNTIME_DIR");
    command.env("ROBOCELL_STATE_DIR", base().path());
    let allowed = Command::new("unshare").args(["-m", "true"]).status();
    if !allowed.is_ok_and(|status| status.success()) {
        eprintln!("skipped: a mount namespace is for root");
        return;
    }
    let said = finish(command);
    assert_eq!(said.stdout.matches("code 3").count(), 3, "{said:?}");
    // A page may become free meanwhile.
    let (named, needed) = ("/dev/shm has ", " KiB free, a command needs");
    let all = [named, needed].map(|words| said.stderr.matches(words).count());
    assert_eq!(all, [3, 3], "{said:?}");
}
