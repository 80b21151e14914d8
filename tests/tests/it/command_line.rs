//! The command line as a contract.

use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};

/// First words of the lines between `Commands:` and the next empty line.
fn commands(help: &str) -> Vec<String> {
    let lines = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"))
        .skip(1);
    let lines = lines.take_while(|line| !line.is_empty());
    lines
        .filter_map(|line| line.split_whitespace().next().map(str::to_owned))
        .collect()
}

#[test]
fn help_lists_what_works_and_nothing_else() {
    let said = finish(robocell(base().path(), &["--help"]));
    let wanted = [
        "run",
        "list",
        "status",
        "top",
        "down",
        "doctor",
        "logs",
        "incident",
        "load",
        "record",
        "replay",
        "shot",
        "film",
        "assets",
        "restart",
        "pause",
        "resume",
        "step",
        "speed",
        "break",
        "reset",
        "task",
        "target",
        "joints",
        "gripper",
        "drag",
        "drop-parts",
        "add-bin",
        "bt",
        "fsm",
        "schema",
        "bench",
        "chaos",
        "eval",
        "new",
        "completions",
        "man",
        "help",
    ];
    assert_eq!(commands(&said.stdout), wanted);
    assert!(said.stdout.contains("Exit codes: 0 done"));
}

#[test]
fn run_has_the_options_scripts_depend_on() {
    let said = finish(robocell(base().path(), &["run", "--help"]));
    for option in [
        "--policy",
        "--seed",
        "--speed",
        "--headless",
        "--one-process",
        "--until-done",
        "--timeout",
        "--script",
        "--paused",
        "--robot",
        "--xrdf",
        "--rmpflow",
        "--json",
        "--cell",
        "--data",
        "--no-watchdog",
        "--record",
        "--listen",
        "--bins",
    ] {
        assert!(said.stdout.contains(option), "{option}");
    }
}

#[test]
fn the_demos_are_listed_with_their_policies() {
    let said = finish(robocell(base().path(), &["list", "--json"]));
    assert_eq!(said.code, 0, "{said:?}");
    let list = said.json();
    let stack = list["demos"]
        .as_array()
        .unwrap()
        .iter()
        .find(|demo| demo["name"] == "franka-stack")
        .unwrap();
    assert_eq!(stack["default_policy"], "fsm");
    assert!(
        stack["policies"]
            .as_array()
            .unwrap()
            .iter()
            .any(|policy| policy == "ifelse")
    );
    assert_eq!(list["running"].as_array().unwrap().len(), 0);
}

#[test]
fn doctor_gives_a_fix_for_everything_it_finds() {
    let said = finish(robocell(base().path(), &["doctor", "--json"]));
    for check in said.json().as_array().unwrap() {
        assert_eq!(check["verdict"] == "ok", check["fix"].is_null(), "{check}");
    }
}

#[test]
fn completions_know_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let said = finish(robocell(base().path(), &["completions", shell]));
        assert!(said.code == 0 && said.stdout.contains("restart"), "{shell}");
    }
}
