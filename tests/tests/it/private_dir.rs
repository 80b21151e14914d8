//! Run directories that another user can change are used by no command.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt as _, chown, symlink};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use robocell_tests::cell::{TestCell, base, pid};
use robocell_tests::program::{Said, built, finish, robocell, wait_for};

/// A user with no name and no files.
const OTHER: u32 = 61_234;

/// Commands that read files of a run directory, or connect to sockets in it.
const COMMANDS: [&[&str]; 10] = [
    &["run", "reach", "--headless"],
    &["run", "reach", "--headless", "--one-process"],
    &["status"],
    &["down"],
    &["list"],
    &["doctor"],
    &["logs"],
    &["incident"],
    &["restart", "task"],
    &["pause"],
];

fn is_refused(said: &Said, arguments: &[&str], words: &[&str]) {
    assert_eq!(said.code, 3, "{arguments:?}: {said:?}");
    let text = format!("{}{}", said.stdout, said.stderr);
    for word in words {
        assert!(text.contains(word), "{arguments:?}: {word}: {said:?}");
    }
}

fn set_mode(path: &Path, mode: u32) {
    fs::set_permissions(path, Permissions::from_mode(mode)).expect("a mode");
}

#[test]
fn a_directory_of_run_directories_that_others_can_change_is_refused_by_each_command() {
    let dir = base();
    let (open, link) = (dir.path().join("open"), dir.path().join("link"));
    fs::create_dir(&open).expect("a directory");
    symlink(&open, &link).expect("a link");
    let shown = open.display().to_string();
    for arguments in COMMANDS {
        set_mode(&open, 0o777);
        let said = finish(robocell(&open, arguments));
        is_refused(&said, arguments, &[&shown, "777", "ROBOCELL_RUN_DIR"]);
        set_mode(&open, 0o700);
        // By its name, and by one that the system follows.
        for link in [link.clone(), PathBuf::from(format!("{}/", link.display()))] {
            let said = finish(robocell(&link, arguments));
            is_refused(&said, arguments, &["symbolic link"]);
        }
    }
    // The directory of one cell.
    let cell = open.join("cell");
    fs::create_dir(&cell).expect("a directory");
    fs::write(cell.join("lock"), "1").expect("a lock");
    for mode in [0o750, 0o702] {
        set_mode(&cell, mode);
        for arguments in [["status"], ["down"], ["logs"]] {
            let said = finish(robocell(&open, &arguments));
            is_refused(&said, &arguments, &[&format!("mode {mode:o}"), "--cell"]);
        }
    }
    fs::remove_dir_all(&cell).expect("removed");
    assert_eq!(fs::read_dir(&open).expect("entries").count(), 0);
}

#[test]
fn a_default_run_directory_that_another_user_made_first_is_refused() {
    let dir = base();
    let default = PathBuf::from(format!("/dev/shm/robocell-{OTHER}"));
    let of_other = |arguments: &[&str]| {
        let mut command = Command::new(built("robocell"));
        command.args(arguments).uid(OTHER).gid(OTHER);
        command.env_remove("ROBOCELL_RUN_DIR");
        command.env_remove("XDG_RUNTIME_DIR");
        command.current_dir("/").env("HOME", "/nonexistent");
        command
    };
    // Only the superuser can be two users, and the other one has to reach the program.
    let can_give = chown(dir.path(), Some(OTHER), None).is_ok();
    if !can_give || of_other(&["--version"]).output().is_err() {
        eprintln!("skipped: this test has to be two users, and this user cannot");
        return;
    }
    chown(dir.path(), Some(0), None).expect("given back");
    // Left by a run of this test that failed.
    fs::remove_dir_all(&default).ok();
    fs::create_dir(&default).expect("a directory");
    for mode in [0o777, 0o755, 0o700] {
        set_mode(&default, mode);
        for arguments in COMMANDS {
            let said = finish(of_other(arguments));
            // Of mode 700 nothing can be read, either way.
            is_refused(&said, arguments, &["belongs to user 0"]);
        }
    }
    fs::remove_dir(&default).expect("nothing in it");
    symlink(dir.path(), &default).expect("a link");
    let outcomes = COMMANDS.map(|arguments| finish(of_other(arguments)));
    fs::remove_file(&default).expect("removed");
    for (said, arguments) in outcomes.iter().zip(COMMANDS) {
        is_refused(said, arguments, &["symbolic link"]);
    }
}

#[test]
fn a_process_opens_the_run_file_that_the_launcher_hands_to_it() {
    let cell = TestCell::start(&["reach", "--headless", "--paused"]);
    let before = pid(&cell.wait_up(), "task");
    let words = fs::read_to_string(format!("/proc/{before}/cmdline")).expect("a process");
    assert!(words.contains("--spec\0/proc/self/fd/0\0"), "{words:?}");
    // No link at its path is followed.
    let file = cell.run_dir().join("run.json");
    let kept = cell.run_dir().join("kept.json");
    fs::rename(&file, &kept).expect("renamed");
    symlink(&kept, &file).expect("a link");
    cell_rt::process::kill(before, cell_rt::process::SIGKILL).expect("killed");
    wait_for("the refusal", || {
        let said = fs::read_to_string(cell.base().join("stderr")).ok()?;
        said.contains("its run file").then_some(())
    });
}
