//! The command line as a contract.

use robocell_tests::cell::base;
use robocell_tests::program::{built, finish, robocell};

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
        "plot",
        "replay",
        "export",
        "camera",
        "assets",
        "spheres",
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
        "grasp",
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
        "--tip",
        "--xrdf",
        "--rmpflow",
        "--json",
        "--cell",
        "--data",
        "--no-watchdog",
        "--record",
        "--listen",
        "--bins",
        "--set",
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
    for check in said.json()["checks"].as_array().unwrap() {
        assert_eq!(check["verdict"] == "ok", check["fix"].is_null(), "{check}");
        assert_eq!(check["verdict"] == "ok", check["cost"].is_null(), "{check}");
    }
    let names: Vec<_> = said.json()["checks"].as_array().unwrap().clone();
    for name in ["Node.js", "npm", "cores", "CPU governor"] {
        assert!(names.iter().any(|check| check["name"] == name), "{name}");
    }
}

#[test]
fn doctor_says_what_a_missing_program_costs() {
    let mut command = robocell(base().path(), &["doctor"]);
    command.env("PATH", "/nonexistent");
    let said = finish(command).stdout;
    for words in ["warn  Node.js", "cost: a checkout cannot build the page"] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn every_page_the_manual_refers_to_exists() {
    let base = base();
    let dir = base.path().join("man");
    let said = finish(robocell(
        base.path(),
        &["man", "--dir", dir.to_str().unwrap()],
    ));
    assert_eq!(said.code, 0, "{said:?}");
    let pages: Vec<_> = std::fs::read_dir(&dir).unwrap().flatten().collect();
    assert!(pages.len() > 40, "{}", pages.len());
    for page in pages {
        let text = std::fs::read_to_string(page.path()).unwrap();
        let plain = text
            .replace("\\-", "-")
            .replace("\\fR", "")
            .replace("\\fB", "");
        for word in plain.split(|c: char| c.is_whitespace() || c == ',') {
            if let Some(name) = word.strip_suffix("(1)") {
                assert!(
                    dir.join(format!("{name}.1")).is_file(),
                    "{word} in {page:?}"
                );
            }
        }
    }
    let one = finish(robocell(base.path(), &["man", "bt", "show"]));
    assert!(one.stdout.contains("robocell-bt-show"), "{one:?}");
    let none = finish(robocell(base.path(), &["man", "bt", "shov"]));
    assert!(
        none.code == 2 && none.stderr.contains("did you mean `show`?"),
        "{none:?}"
    );
}

/// What bash offers for the last of `words`.
fn offered(base: &std::path::Path, words: &str) -> String {
    let robocell = built("robocell");
    let bin = robocell.parent().unwrap().display();
    let last = words.split(' ').count() - 1;
    let script = format!(
        "PATH={bin}:$PATH; source <(robocell completions bash); COMP_WORDS=({words}); \
         COMP_CWORD={last}; _robocell_names robocell \"${{COMP_WORDS[-1]}}\" \"${{COMP_WORDS[-2]}}\"; echo \"${{COMPREPLY[*]}}\""
    );
    let mut bash = std::process::Command::new("bash");
    bash.args(["--norc", "-c", &script])
        .env("ROBOCELL_RUN_DIR", base);
    finish(bash).stdout
}

#[test]
fn completions_offer_demos_and_policies() {
    let base = base();
    let demos = offered(base.path(), "robocell run fra");
    assert!(
        demos.contains("franka-stack") && !demos.contains("reach"),
        "{demos}"
    );
    let policies = offered(base.path(), "robocell eval franka-stack --policy i");
    assert_eq!(policies.trim(), "ifelse");
    assert!(offered(base.path(), "robocell run reach --spe").contains("--speed"));
}

#[test]
fn completions_know_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let said = finish(robocell(base().path(), &["completions", shell]));
        assert!(said.code == 0 && said.stdout.contains("restart"), "{shell}");
    }
}
