//! Logs are bounded, and the kept part has no gap.

use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{built, wait_for};

/// Lines that the task prints before it works, some 30 MB.
const LINES: usize = 500_000;

/// A task program that prints [`LINES`] lines at its start, then is the built-in one.
fn talkative(dir: &Path) -> PathBuf {
    let path = dir.join("talkative");
    let task = built("task-proc");
    let text = format!(
        "#!/bin/sh\n[ \"$1\" = --spec ] && seq -f 'line %08.0f of a task that prints more than \
         anybody reads' 1 {LINES}\nexec {} \"$@\"\n",
        task.display()
    );
    std::fs::write(&path, text).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

/// Bytes that the files of a directory occupy.
fn bytes(dir: &Path) -> u64 {
    let entries = std::fs::read_dir(dir).unwrap().flatten();
    let lengths = entries.filter_map(|entry| Some(entry.metadata().ok()?.blocks() * 512));
    lengths.sum()
}

#[test]
fn a_task_that_prints_without_end_keeps_its_newest_lines_and_fills_no_memory() {
    let base = base();
    let task = talkative(base.path());
    let arguments = ["cube", "--headless", "--task", task.to_str().unwrap()];
    let cell = TestCell::start_in(base, &arguments);
    cell.wait_status("a task that works", |status| status["outcome"] == "running");
    let last = format!("line {LINES:08} of a task");
    let said = wait_for("the last line", || {
        let said = cell.ask(&["logs", "task"]);
        said.stdout.contains(&last).then_some(said)
    });
    let logs = cell.run_dir().join("logs");
    assert!(bytes(&logs) < 11_000_000, "{} bytes", bytes(&logs));
    // The kept part has no gap.
    let number = |line: &str| line.split(' ').find_map(|word| word.parse::<usize>().ok());
    let numbers: Vec<_> = said.stdout.lines().filter_map(number).collect();
    assert!(numbers.len() > 10_000, "{}", numbers.len());
    assert!(numbers.is_sorted_by(|a, b| *b == a + 1));
    let stderr = std::fs::read_to_string(cell.base().join("stderr")).unwrap();
    assert_eq!(
        stderr.matches("the log of task is long").count(),
        1,
        "{stderr}"
    );
    // An incident has the end of the log.
    let pid = cell.status().unwrap()["processes"]
        .as_array()
        .unwrap()
        .iter()
        .find_map(|one| (one["name"] == "task").then(|| one["pid"].as_u64().unwrap()));
    cell_rt::process::kill(
        u32::try_from(pid.unwrap()).unwrap(),
        cell_rt::process::SIGKILL,
    )
    .unwrap();
    let incident = wait_for("an incident", || {
        let said = cell.ask(&["incident", "1"]);
        (said.code == 0).then_some(said)
    });
    assert!(incident.stdout.contains(&last), "{}", incident.stdout);
}
