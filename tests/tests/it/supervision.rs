//! The launcher as the keeper of its processes.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use cell_rt::process::{SIGCONT, SIGSTOP, kill};
use robocell_tests::assert::{all_gone, prefix, refused, segments};
use robocell_tests::cell::{TestCell, base, generation, pid};
use robocell_tests::fault::{freeze_and_wait, kill_and_wait, kill_in_creation};
use robocell_tests::program::{finish, robocell, wait_for};

const NAMES: [&str; 4] = ["physics", "controller-0", "task", "monitor"];

fn idle_cell() -> TestCell {
    TestCell::start(&["franka-stack", "--headless", "--paused"])
}

#[test]
fn a_cell_comes_up_answers_and_goes_down_without_a_trace() {
    let mut cell = idle_cell();
    let status = cell.wait_up();
    assert_eq!(
        (&status["demo"], &status["paused"]),
        (&"franka-stack".into(), &true.into())
    );
    let pids: Vec<u32> = NAMES.iter().map(|name| pid(&status, name)).collect();
    let prefix = prefix(&cell.run_dir());
    assert!(!segments(&prefix).is_empty());

    let frame = cell.ask(&["top"]);
    assert!(
        NAMES.iter().all(|name| frame.stdout.contains(name)),
        "{frame:?}"
    );
    assert_eq!(cell.ask(&["logs"]).code, 0);

    assert_eq!(cell.ask(&["down"]).code, 0);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    all_gone(&pids);
    assert_eq!(segments(&prefix), Vec::<String>::new());
    refused(&cell.ask(&["status"]), 4, &["no cell `cell`"]);
}

#[test]
fn a_second_run_of_the_same_cell_is_told_who_was_first() {
    let cell = idle_cell();
    cell.wait_up();
    let said = finish(robocell(cell.base(), &["run", "franka-stack"]));
    refused(
        &said,
        3,
        &[
            "running already",
            &format!("pid {}", cell.launcher()),
            "UTC",
            "robocell down",
        ],
    );
    assert!(cell.status().is_some(), "the first one still runs");
}

#[test]
fn each_process_is_brought_back_after_kill_9() {
    let cell = idle_cell();
    for name in NAMES {
        kill_and_wait(&cell, name);
    }
    cell.wait_up();
}

#[test]
fn a_pause_is_no_hang() {
    let cell = idle_cell();
    let before = cell.wait_up();
    let seen = std::time::Instant::now();
    // Longer than any hang limit but the monitor's.
    let after = cell.wait_status("a while in a pause", |_| seen.elapsed().as_millis() > 1_500);
    for name in NAMES {
        assert_eq!(pid(&before, name), pid(&after, name), "{name}");
    }
}

#[test]
fn a_stopped_process_is_replaced() {
    let cell = idle_cell();
    freeze_and_wait(&cell, "task");
    freeze_and_wait(&cell, "controller-0");
}

#[test]
fn a_process_killed_while_it_creates_shared_memory_stops_nobody() {
    for name in NAMES {
        let mut cell = idle_cell();
        let before = cell.wait_up();
        kill(cell.launcher(), SIGSTOP).unwrap();
        assert!(kill_in_creation(&cell, name) > 0, "{name} has connections");
        kill(cell.launcher(), SIGCONT).unwrap();
        cell.wait_status("a new start", |status| {
            generation(status, name) > generation(&before, name)
        });
        cell.wait_up();
        assert_eq!(cell.ask(&["down"]).code, 0);
        let said = cell.wait_end();
        assert_eq!(said.code, 0, "{said:?}");
        assert_eq!(segments(&prefix(&cell.run_dir())), Vec::<String>::new());
    }
}

#[test]
fn a_directory_of_somebody_else_is_not_emptied() {
    let base = robocell_tests::cell::base();
    let foreign = base.path().join("cell");
    std::fs::create_dir(&foreign).unwrap();
    std::fs::write(foreign.join("thesis.tex"), "x").unwrap();
    for arguments in [["run", "franka-stack"], ["run", "reach"]] {
        let said = finish(robocell(base.path(), &arguments));
        refused(&said, 3, &[&foreign.display().to_string(), "--cell"]);
    }
    assert!(foreign.join("thesis.tex").exists());
}

#[test]
fn restart_starts_one_process_anew_with_another_policy() {
    let cell = idle_cell();
    let before = cell.wait_up();
    refused(
        &cell.ask(&["restart", "task", "--policy", "ifels"]),
        3,
        &["did you mean 'ifelse'?"],
    );
    let said = cell.ask(&["restart", "task", "--policy", "ifelse"]);
    assert_eq!(said.code, 0, "{said:?}");
    let after = cell.wait_status("a new task", |status| {
        generation(status, "task") > generation(&before, "task")
    });
    assert_eq!(pid(&before, "physics"), pid(&after, "physics"));
}

#[test]
fn children_end_with_a_launcher_that_was_killed_and_the_next_start_is_clean() {
    let cell = idle_cell();
    let status = cell.wait_up();
    let pids: Vec<u32> = NAMES.iter().map(|name| pid(&status, name)).collect();
    let old = prefix(&cell.run_dir());
    let base = cell.crash();
    all_gone(&pids);

    let cell = TestCell::start_in(base, &["franka-stack", "--headless", "--paused"]);
    cell.wait_up();
    // A process that died while it wrote is cleaned up after once more.
    wait_for("nothing of the old run", || {
        segments(&old).is_empty().then_some(())
    });
    let said = std::fs::read_to_string(cell.base().join("stderr")).unwrap();
    assert_eq!(
        said.matches("removed leftovers of a crashed run").count(),
        1,
        "{said}"
    );
}

#[test]
fn a_stopped_process_does_not_outlive_a_launcher_that_was_killed() {
    for name in NAMES {
        let cell = idle_cell();
        let status = cell.wait_up();
        let pids: Vec<u32> = NAMES.iter().map(|name| pid(&status, name)).collect();
        kill(pid(&status, name), SIGSTOP).unwrap();
        let left = prefix(&cell.run_dir());
        let _base = cell.crash();
        all_gone(&pids);
        // The next start in the directory would; there is none.
        for segment in segments(&left) {
            std::fs::remove_file(Path::new("/dev/shm").join(segment)).unwrap();
        }
    }
}

/// No connection can wake a thread that waits at a socket whose file was deleted.
#[test]
fn processes_end_with_their_launcher_when_the_run_directory_is_gone_too() {
    let cell = idle_cell();
    let status = cell.wait_up();
    let pids: Vec<u32> = NAMES.iter().map(|name| pid(&status, name)).collect();
    let left = prefix(&cell.run_dir());
    std::fs::remove_dir_all(cell.run_dir()).unwrap();
    let _base = cell.crash();
    all_gone(&pids);
    for segment in segments(&left) {
        std::fs::remove_file(Path::new("/dev/shm").join(segment)).unwrap();
    }
}

/// `robocell ARGUMENTS` in a shell that runs `before` first.
fn after(before: &str, base: &Path, arguments: &[&str]) -> Command {
    let ours = robocell(base, arguments);
    let mut shell = Command::new("sh");
    shell
        .args(["-c", &format!("{before}; exec \"$@\""), "sh"])
        .arg(ours.get_program())
        .args(ours.get_args())
        .envs(
            ours.get_envs()
                .filter_map(|(name, value)| Some((name, value?))),
        );
    shell
}

#[test]
fn low_limits_are_raised_where_the_user_may() {
    let base = base();
    let arguments = [
        "run",
        "reach",
        "--headless",
        "--speed",
        "max",
        "--timeout",
        "1",
    ];
    for limit in ["ulimit -Sn 64", "ulimit -Ss 256"] {
        let said = finish(after(limit, base.path(), &arguments));
        assert_eq!(said.code, 5, "{limit}: {said:?}");
        assert!(said.stdout.contains("out of time after 1.00 s"), "{said:?}");
    }
}

#[test]
fn signals_that_mean_nothing_do_nothing_and_sigquit_ends_the_cell_in_order() {
    let mut cell = idle_cell();
    cell.wait_up();
    for signal in [libc_signal("USR1"), libc_signal("USR2")] {
        kill(cell.launcher(), signal).unwrap();
    }
    assert!(cell.status().is_some() && cell.is_running());
    let segment = prefix(&cell.run_dir());
    kill(cell.launcher(), libc_signal("QUIT")).unwrap();
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    assert_eq!(segments(&segment), Vec::<String>::new());
    for file in ["page.json", "record.sock", "control.sock", "children.json"] {
        assert!(!cell.run_dir().join(file).exists(), "{file}");
    }
}

/// Numbers of signals on Linux (signal(7)).
fn libc_signal(name: &str) -> i32 {
    match name {
        "QUIT" => 3,
        "USR1" => 10,
        _ => 12,
    }
}

#[test]
fn two_cells_run_side_by_side() {
    let cell = idle_cell();
    let base = cell.base().to_owned();
    let mut other = robocell(
        &base,
        &[
            "run",
            "franka-stack",
            "--headless",
            "--paused",
            "--cell",
            "other",
        ],
    );
    let mut other = other.stdout(std::process::Stdio::null()).spawn().unwrap();
    cell.wait_up();
    wait_for("the other cell", || {
        let said = finish(robocell(&base, &["status", "--cell", "other", "--json"]));
        (said.code == 0).then_some(())
    });
    assert_eq!(
        finish(robocell(&base, &["down", "--cell", "other"])).code,
        0
    );
    assert!(other.wait().unwrap().success());
    assert!(cell.status().is_some());
}

/// `load` asks the task program, which may take minutes: it builds itself, or imports much.
#[test]
fn processes_are_kept_and_clients_answered_while_another_scene_is_planned() {
    let base = base();
    let (task, hold) = (base.path().join("task.sh"), base.path().join("hold"));
    let asked = base.path().join("asked");
    let script = format!(
        "#!/bin/sh\nif [ \"$1\" = behaviour ] && [ -e {hold} ]; then\n\
         touch {asked}\nwhile [ -e {hold} ]; do sleep 0.02; done\nfi\nexec {program} \"$@\"\n",
        hold = hold.display(),
        asked = asked.display(),
        program = robocell_tests::program::built("task-proc").display()
    );
    std::fs::write(&task, script).unwrap();
    std::fs::set_permissions(&task, std::fs::Permissions::from_mode(0o700)).unwrap();
    let task = task.to_str().unwrap();
    let arguments = ["franka-stack", "--headless", "--paused", "--task", task];
    let mut cell = TestCell::start_in(base, &arguments);
    cell.wait_up();
    let load = |cell: &TestCell, seed| {
        std::fs::write(&hold, "").unwrap();
        let mut command = robocell(cell.base(), &["load", "franka-stack", "--seed", seed]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        wait_for("the question", || asked.exists().then_some(()));
        std::fs::remove_file(&asked).unwrap();
        child
    };
    let ended = |child: Child| {
        let output = child.wait_with_output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };

    let first = load(&cell, "3");
    kill_and_wait(&cell, "task");
    refused(&cell.ask(&["load", "franka-stack"]), 3, &["set up already"]);
    std::fs::remove_file(&hold).unwrap();
    assert_eq!(ended(first).0, Some(0));
    assert_eq!(cell.wait_up()["seed"], 3);

    let second = load(&cell, "4");
    assert_eq!(cell.ask(&["down"]).code, 0);
    assert_eq!(cell.wait_end().code, 0);
    assert_eq!(
        ended(second),
        (Some(3), "robocell: the cell has ended\n".to_owned())
    );
}

/// Starts that hang may be due to shared memory that cannot be repaired: after three
/// all processes start again on a new bus, and resume.
#[test]
fn a_process_that_never_works_on_one_bus_is_tried_on_another() {
    let base = base();
    let task = base.path().join("task.sh");
    let program = robocell_tests::program::built("task-proc");
    // Works the fourth time.
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = --spec ] && [ \"$4\" -lt 4 ] && exec sleep 1000\nexec {} \"$@\"\n",
        program.display()
    );
    std::fs::write(&task, script).unwrap();
    std::fs::set_permissions(&task, std::fs::Permissions::from_mode(0o700)).unwrap();
    let arguments = [
        "franka-stack",
        "--headless",
        "--task",
        task.to_str().unwrap(),
    ];
    let cell = TestCell::start_in(base, &arguments);
    let status = cell.wait_status("the second bus", |status| {
        generation(status, "task") == 4 && generation(status, "physics") == 2
    });
    let resumed = status["tick"].as_u64().unwrap();
    assert!(
        resumed > 3_000,
        "physics starts from the beginning: {resumed}"
    );
    cell.wait_status("work", |status| status["outcome"] == "running");
    // Nothing of the first bus is left.
    let prefix = prefix(&cell.run_dir());
    let family = &prefix[..8];
    let foreign = |name: &String| !name.starts_with(&prefix);
    assert!(!segments(family).iter().any(foreign));
    let roots = std::fs::read_dir(cell.run_dir()).unwrap();
    let roots = roots.filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        let name = name.to_str().unwrap();
        name.len() == 5 && name.starts_with('b')
    });
    assert_eq!(roots.count(), 1);
    let said = std::fs::read_to_string(cell.base().join("stderr")).unwrap();
    assert!(said.contains("shared memory is replaced: task"), "{said}");
}
