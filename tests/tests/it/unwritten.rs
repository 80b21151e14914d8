//! Output without a reader, and output that could not be written.

use std::fs::OpenOptions;
use std::process::Stdio;

use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{robocell, wait_for};

#[test]
fn a_result_on_a_full_disk_is_a_failure_of_every_command() {
    let base = base();
    let cell = TestCell::start(&["cube", "--headless", "--paused"]);
    cell.wait_up();
    let commands = [
        "list",
        "list --json",
        "doctor --json",
        "schema output run",
        "schema wire",
        "man run",
        "completions bash",
        "status",
        "status --json",
        "top",
        "top --json",
        "fsm show --live",
        "--help",
        "run --help",
        "schema cell",
        "fsm show cube",
        "eval reach --seeds 1..1 --timeout 0.1",
        "eval reach --seeds 1..1 --timeout 0.1 --json",
        "run reach --headless --one-process --timeout 0.1 --json",
        "--version",
        "run reach --headless --speed max --timeout 0.1 --cell other",
        "run reach --headless --speed max --timeout 0.1 --json --cell other",
    ];
    for line in commands {
        let arguments: Vec<&str> = line.split(' ').collect();
        let base = if line.starts_with("run r") {
            base.path()
        } else {
            cell.base()
        };
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = robocell(base, &arguments);
        let said = command.stdout(Stdio::from(full)).output().unwrap();
        let stderr = String::from_utf8_lossy(&said.stderr);
        assert!(
            matches!(said.status.code(), Some(3 | 5)),
            "{line}: {said:?}"
        );
        assert!(
            stderr.contains("cannot write to standard output: No space left on device"),
            "{line}: {stderr}"
        );
    }
}

#[test]
fn a_command_that_follows_ends_when_its_reader_does() {
    let cell = TestCell::start(&["cube", "--headless", "--policy", "fsm", "--paused"]);
    cell.wait_up();
    // Nothing more is written while the cell is paused.
    for line in ["logs -f", "bt show --live", "fsm show --live"] {
        let arguments: Vec<&str> = line.split(' ').collect();
        let mut command = robocell(cell.base(), &arguments);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let status = wait_for("its end", || child.try_wait().unwrap());
        assert!(status.success(), "{line}: {status}");
    }
}

#[test]
fn an_argument_that_is_not_utf_8_is_refused_as_such() {
    use std::os::unix::ffi::OsStrExt;
    let base = base();
    let name = std::ffi::OsStr::from_bytes(b"caf\xe9.mcap");
    std::fs::write(base.path().join(name), "").unwrap();
    for before in [
        &["run", "cube", "--script"][..],
        &["run", "cube", "--record"],
        &["replay"],
        &["plot"],
        &["eval", "report"],
        &["bt", "check"],
        &["run", "cube", "--task"],
        &["list", "--data"],
    ] {
        let mut command = robocell(base.path(), before);
        let said = command.arg(base.path().join(name)).output().unwrap();
        let stderr = String::from_utf8_lossy(&said.stderr);
        assert_eq!(said.status.code(), Some(2), "{before:?}: {stderr}");
        assert!(stderr.contains(r"caf\xe9.mcap"), "{before:?}: {stderr}");
        assert!(stderr.contains("not valid UTF-8"), "{before:?}: {stderr}");
    }
}
