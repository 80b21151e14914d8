//! Leaves that answer without being run, for a test of the tree around them.

use std::path::Path;

use robocell_tests::assert::{nothing_started, refused};
use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use robocell_tests::recording::{same, verify};

const CUBE: [&str; 5] = ["run", "cube", "--policy", "json", "--until-done"];
const ONE: [&str; 2] = ["--one-process", "--json"];
const FOUR: [&str; 4] = ["--headless", "--speed", "max", "--json"];

fn cube(base: &Path, more: &[&str]) -> Said {
    finish(robocell(base, &[&CUBE[..], more].concat()))
}

fn hash(said: &Said) -> String {
    assert_eq!(said.code, 0, "{said:?}");
    said.json()["state_hash"]
        .as_str()
        .expect("a hash")
        .to_owned()
}

#[test]
fn a_run_is_the_same_while_no_rule_applies() {
    let base = base();
    let rules = base.path().join("rules.jsonl");
    let late = r#"{"node": "grasp", "result": "failure", "from_s": 500, "for_s": 1}"#;
    std::fs::write(&rules, format!("{late}\n")).expect("a file");
    let rules = rules.display().to_string();
    let plain = hash(&cube(base.path(), &ONE));
    let late = cube(base.path(), &[&ONE[..], &["--replace", &rules]].concat());
    assert_eq!(hash(&late), plain);
    let never = cube(
        base.path(),
        &[&ONE[..], &["--replace", "grasp=failure:0"]].concat(),
    );
    assert_eq!(hash(&never), plain);
}

#[test]
fn a_rule_holds_in_four_processes_and_after_a_kill_and_is_computed_again() {
    let base = base();
    let rule = ["--replace", "grasp=running:3"];
    let one = cube(base.path(), &[&ONE[..], &rule].concat());
    assert_ne!(hash(&one), hash(&cube(base.path(), &ONE)));
    let script = base.path().join("kill.jsonl");
    let kill = |at| format!("{{\"at_s\": {at}, \"do\": \"kill\", \"process\": \"task\"}}\n");
    std::fs::write(&script, kill(2.5) + &kill(4.5)).expect("a script");
    let file = base.path().join("run.mcap");
    let (script, name) = (script.display().to_string(), file.display().to_string());
    let options = ["--script", &script, "--record", &name];
    let four = cube(base.path(), &[&FOUR[..], &rule, &options].concat());
    assert_eq!(four.json()["task_restarts"], 2, "{four:?}");
    assert_eq!(hash(&four), hash(&one));
    same(&verify(base.path(), &file, &["--json"]));
}

#[test]
fn what_is_no_leaf_is_refused_before_anything_starts() {
    let base = base();
    for (policy, rule, words) in [
        (
            "json",
            "gras=success",
            "unknown leaf 'gras'; did you mean 'grasp'?",
        ),
        (
            "json",
            "deliver=success",
            "'deliver' is a Sequence, only leaves are replaced",
        ),
        (
            "ifelse",
            "grasp=success",
            "policy 'ifelse': it is not a tree",
        ),
        ("json", "grasp=ok", "write NODE=success, NODE=failure"),
        ("json", "no.jsonl", "no.jsonl"),
    ] {
        let arguments = ["run", "cube", "--policy", policy, "--replace", rule];
        let said = finish(robocell(base.path(), &[&arguments[..], &FOUR].concat()));
        refused(&said, 3, &[words]);
        let arguments = [
            "eval",
            "cube",
            "--policy",
            policy,
            "--replace",
            rule,
            "--seeds",
            "1..1",
        ];
        refused(&finish(robocell(base.path(), &arguments)), 3, &[words]);
    }
    nothing_started(base.path());
}

#[test]
fn eval_replaces_leaves_in_each_episode() {
    let base = base();
    let arguments = [
        "eval", "cube", "--policy", "json", "--seeds", "1..2", "--json",
    ];
    let plain = finish(robocell(base.path(), &arguments));
    assert_eq!(plain.code, 0, "{plain:?}");
    let rule = ["--replace", "grasp=running", "--timeout", "8"];
    let never = finish(robocell(base.path(), &[&arguments[..], &rule].concat()));
    let last = never.stdout.lines().last().expect("a line").to_owned();
    assert!(
        last.contains("\"done\":0") || last.contains("\"done\": 0"),
        "{last}"
    );
}
