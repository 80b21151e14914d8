//! What commands say to people: the end of a run, what a cell waits for, and errors.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;

use robocell_tests::cell::{TestCell, base};
use robocell_tests::http::{ask, parts};
use robocell_tests::program::{finish, robocell, wait_for};

fn stdout(cell: &TestCell) -> String {
    std::fs::read_to_string(cell.base().join("stdout")).unwrap_or_default()
}

/// Waits until `words` are on the stdout of the launcher.
fn wait_said(cell: &TestCell, words: &str) -> String {
    wait_for(words, || {
        Some(stdout(cell)).filter(|said| said.contains(words))
    })
}

#[test]
fn run_says_when_the_task_is_done_and_ends_with_its_summary() {
    let mut cell = TestCell::start(&["cube", "--headless", "--speed", "max"]);
    let said = wait_said(&cell, "done at ");
    assert!(said.contains("`robocell reset` plays it again"), "{said}");
    assert_eq!(cell.ask(&["down"]).code, 0);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    for words in ["done after ", "placed cube; ", "(`robocell replay "] {
        assert!(said.stdout.contains(words), "no {words:?}: {said:?}");
    }
}

#[test]
fn a_run_that_is_stopped_says_how_far_it_came() {
    let mut cell = TestCell::start(&["reach", "--headless", "--json"]);
    cell.wait_up();
    assert_eq!(cell.ask(&["down"]).code, 0);
    let said = cell.wait_end();
    assert_eq!(said.json()["outcome"], "stopped", "{said:?}");
}

#[test]
fn a_cell_that_waits_says_for_what_and_the_arm_of_reach_is_described() {
    let cell = TestCell::start(&["ur10-fill-bin", "--headless", "--speed", "max"]);
    wait_said(&cell, "waiting for: `robocell task start`");
    let cell = TestCell::start(&["reach", "--headless", "--paused"]);
    let said = wait_said(&cell, "waiting for: `robocell resume`");
    for words in [
        "joints  ",
        "panda_joint1",
        "tool frame  ",
        "collision spheres  ",
        "tuning  ",
    ] {
        assert!(said.contains(words), "no {words:?}: {said}");
    }
}

#[test]
fn a_loop_plays_the_next_seed_until_it_is_stopped() {
    let words = [
        "cube",
        "--headless",
        "--speed",
        "max",
        "--loop",
        "--seed",
        "4",
    ];
    let mut cell = TestCell::start(&words);
    let said = wait_said(&cell, "seed 6,");
    assert!(said.contains("seed 5,"), "{said}");
    cell.wait_status("the third seed", |status| status["seed"] == 6);
    assert_eq!(cell.ask(&["down"]).code, 0);
    assert_eq!(cell.wait_end().code, 0);
}

/// A program in `dir` that does what `script` says.
fn program(dir: &Path, name: &str, script: &str) {
    std::fs::create_dir_all(dir).expect("a directory");
    let path = dir.join(name);
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).expect("a program");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).expect("a program");
}

/// Where there is a page, the task starts when it is open.
fn starts_with_its_page(cell: &TestCell, link: &str) {
    wait_said(cell, "Ctrl-C stops it");
    if stdout(cell).contains("note: ") {
        return eprintln!("the start that waits for the page is skipped: no page is built");
    }
    assert!(
        stdout(cell).contains("waiting for: the page"),
        "{}",
        stdout(cell)
    );
    let before = cell.wait_status("the pause", |status| status["paused"] == true);
    assert_eq!(before["tick"], 0);
    let (address, token) = parts(link);
    let exchange = format!("GET /?token={token}");
    wait_for("the page", || ask(&address, &exchange, &[]));
    cell.wait_status("the start", |status| status["paused"] == false);
}

#[test]
fn open_hands_the_link_to_the_browser_or_says_what_is_missing() {
    let base = base();
    let (bin, opened) = (base.path().join("bin"), base.path().join("opened"));
    program(
        &bin,
        "xdg-open",
        &format!("echo \"$1\" > {}", opened.display()),
    );
    let cell = TestCell::start_with(base, &["franka-stack", "--open"], |command| {
        command.env("PATH", format!("{}:/usr/bin:/bin", bin.display()));
    });
    let link = wait_for("the link", || {
        std::fs::read_to_string(&opened)
            .ok()
            .filter(|link| link.ends_with('\n'))
    });
    assert!(stdout(&cell).contains(link.trim()), "{link}");
    starts_with_its_page(&cell, link.trim());
    drop(cell);
    let run = ["reach", "--paused", "--open"];
    let cell = TestCell::start_with(robocell_tests::cell::base(), &run, |command| {
        command.env("PATH", "/nonexistent");
    });
    wait_for("a message", || {
        let said = std::fs::read_to_string(cell.base().join("stderr")).ok()?;
        said.contains("--open: neither xdg-open nor open is installed")
            .then_some(())
    });
}

#[test]
fn an_error_in_a_file_of_data_names_a_path_that_can_be_opened() {
    let base = base();
    let cells = base.path().join("mine/cells");
    std::fs::create_dir_all(&cells).expect("a directory");
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../cells/");
    let cell = std::fs::read_to_string(format!("{shipped}cube.toml")).expect("a cell");
    let file = cells.join("mine.toml");
    std::fs::write(&file, cell.replace("time_limit_s", "time_limits_s")).expect("a file");
    let mut command = robocell(
        base.path(),
        &["run", "mine", "--data", "mine", "--headless"],
    );
    command.current_dir(base.path());
    let said = finish(command);
    let path = said.stderr.split(':').nth(1).expect("a path").trim();
    assert!(base.path().join(path).is_file(), "{path} in {said:?}");
    let tree = std::fs::read_to_string(format!("{shipped}franka-pyramid.tree.json"));
    let tree = tree
        .expect("a tree")
        .replace("\"SetGripper\"", "\"SetGriper\"");
    std::fs::write(cells.join("franka-pyramid.tree.json"), tree).expect("a file");
    std::fs::copy(
        format!("{shipped}franka-pyramid.toml"),
        cells.join("franka-pyramid.toml"),
    )
    .expect("a file");
    let run = ["run", "franka-pyramid", "--data", "mine", "--headless"];
    let mut command = robocell(base.path(), &run);
    command.current_dir(base.path());
    let said = finish(command);
    let lines: Vec<_> = said.stderr.lines().collect();
    let last = lines.last().expect("a line");
    let path = last.split(':').next().expect("a path");
    assert!(base.path().join(path).is_file(), "{path} in {said:?}");
    assert!(last.contains("SetGriper"), "{said:?}");
}

#[test]
fn an_arm_without_a_gripper_does_not_hold_nothing() {
    let cell = TestCell::start(&["reach", "--headless", "--robot", ARM]);
    cell.wait_up();
    let said = cell.ask(&["status"]).stdout;
    assert!(
        said.contains("no gripper") && !said.contains("holds nothing"),
        "{said}"
    );
    let top = cell.ask(&["top"]);
    assert!(top.code == 0 && !top.stdout.contains('\u{1b}'), "{top:?}");
    assert!(top.stdout.contains("no gripper"), "{top:?}");
    assert!(top.stdout.contains("x real time"), "{top:?}");
}

/// An arm without a hand.
const ARM: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../robots/ur10/ur10.urdf");

#[test]
fn a_replay_is_listed_as_one() {
    let base = base();
    let file = base.path().join("kept.mcap");
    let name = file.display().to_string();
    let run = [
        "run",
        "cube",
        "--headless",
        "--speed",
        "max",
        "--timeout",
        "1",
        "--record",
        &name,
    ];
    finish(robocell(base.path(), &run));
    assert!(file.is_file());
    let replay = TestCell::launch(base, &["replay", &name], |_| {});
    wait_for("a replay", || {
        let said = replay.ask(&["list"]).stdout;
        said.contains(&format!("(replay of {name})")).then_some(())
    });
    let list = replay.ask(&["list", "--json"]).json();
    assert_eq!(list["running"][0]["recording"], name.as_str(), "{list}");
}
