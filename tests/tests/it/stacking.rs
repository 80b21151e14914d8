//! The demo from end to end: four cubes, disturbed and not, with the task
//! being killed on the way.

use std::path::Path;

use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use serde_json::{Value, json};

const CUBES: [&str; 4] = ["red_cube", "blue_cube", "green_cube", "yellow_cube"];

/// Kills that a run must not notice.
const KILLS: &str = r#"
{"at_phase": "LIFT", "nth": 1, "after_s": 0.1, "do": "kill", "process": "task"}
{"at_phase": "TRANSPORT", "nth": 2, "after_s": 0.3, "do": "kill", "process": "task"}
{"at_phase": "LOWER", "nth": 3, "after_s": 0.2, "do": "kill", "process": "task"}
"#;

/// The bottom cube goes while another is held, the next one moves during its
/// approach, and one is pulled out of the hand.
const DRAGS: &str = r#"
{"at_phase": "TRANSPORT", "nth": 2, "after_s": 0.3, "do": "drag", "object": "red_cube", "to": [0.40, 0.35, 0.025]}
{"at_phase": "APPROACH", "nth": 5, "after_s": 0.1, "do": "drag", "object": "green_cube", "to": [0.62, -0.18, 0.025]}
{"at_phase": "TRANSPORT", "nth": 6, "after_s": 0.5, "do": "drag", "object": "yellow_cube", "to": [0.45, 0.0, 0.025]}
"#;

/// Runs the demo to its end in `dir` and gives its summary.
fn stack(dir: &Path, options: &[&str], script: &str) -> Value {
    let file = dir.join("script.jsonl");
    std::fs::write(&file, script).expect("the script is written");
    let file = file.display().to_string();
    let fixed = [
        "run",
        "franka-stack",
        "--headless",
        "--until-done",
        "--json",
        "--script",
        &file,
    ];
    let arguments: Vec<&str> = fixed.iter().chain(options).copied().collect();
    let said = finish(robocell(dir, &arguments));
    assert_eq!(said.code, 0, "{said:?}");
    said.json()
}

fn log(dir: &Path) -> String {
    let path = dir.join("cell/logs/trace.log");
    std::fs::read_to_string(path).expect("the task's log stays after the run")
}

fn assert_stacked(summary: &Value) {
    assert_eq!(summary["outcome"], "done", "{summary}");
    assert_eq!(summary["placed"], json!(CUBES), "{summary}");
    assert_eq!(summary["limit_violations"], 0, "{summary}");
    assert_eq!(summary["script_left"], 0, "{summary}");
}

#[test]
fn one_process_four_processes_and_a_killed_task_end_in_the_same_state() {
    let dir = base();
    let seed = ["--seed", "11"];
    let lockstep = ["--speed", "max", "--seed", "11"];
    let four = stack(dir.path(), &lockstep, "");
    assert_stacked(&four);
    let written = log(dir.path());
    let first = written.lines().next().unwrap_or_default();
    assert!(
        first.contains("0.000 s"),
        "the first line is missing: {written}"
    );
    let again = stack(dir.path(), &lockstep, "");
    let killed = stack(dir.path(), &lockstep, KILLS);
    let one = stack(dir.path(), &["--one-process", seed[0], seed[1]], "");
    assert_eq!(killed["task_restarts"], 3, "{killed}");
    for other in [&again, &killed, &one] {
        assert_eq!(other["state_hash"], four["state_hash"], "{other}");
        assert_eq!(other["ticks"], four["ticks"], "{other}");
    }
    let other_seed = stack(dir.path(), &["--one-process", "--seed", "12"], "");
    assert_ne!(other_seed["state_hash"], four["state_hash"]);
}

#[test]
#[ignore = "slow: .ci/long"]
fn every_disturbance_is_recovered_from_and_said() {
    let dir = base();
    for policy in ["fsm", "ifelse", "bt"] {
        let options = ["--speed", "max", "--seed", "3", "--policy", policy];
        // The tree turns back at once, so it carries once more on the way.
        let script = match policy {
            "bt" => DRAGS.replace(r#""nth": 6"#, r#""nth": 7"#),
            _ => DRAGS.to_owned(),
        };
        let summary = stack(dir.path(), &options, &script);
        assert_stacked(&summary);
        assert_eq!(summary["policy"], policy);
        assert_eq!(
            (&summary["aborts"], &summary["drops"]),
            (&1.into(), &1.into()),
            "{summary}"
        );
        assert!(summary["resyncs"].as_u64() >= Some(1), "{summary}");
        let log = log(dir.path());
        let line = |words: &[&str]| {
            let found = |line: &&str| words.iter().all(|word| line.contains(word));
            log.lines()
                .position(|line| found(&line))
                .unwrap_or_else(|| panic!("no {words:?} in\n{log}"))
        };
        let aborted = line(&["[abort]", "blue_cube"]);
        line(&["[resync]", "green_cube"]);
        line(&["[drop]", "yellow_cube"]);
        line(&["-> all stacked"]);
        // The displaced cube comes first after the held one was put back.
        let next = log
            .lines()
            .skip(aborted)
            .find(|line| line.contains("] -> "));
        assert!(next.is_some_and(|line| line.contains("red_cube")), "{log}");
    }
}

#[test]
fn in_real_time_with_the_task_killed_in_every_carrying_phase_the_same_is_recovered_from() {
    let dir = base();
    let script = format!("{KILLS}{DRAGS}");
    let summary = stack(dir.path(), &["--speed", "1", "--seed", "5"], &script);
    assert_stacked(&summary);
    assert_eq!(summary["task_restarts"], 3, "{summary}");
    // One cube was pulled out of the hand; no kill let another one fall.
    assert_eq!(summary["drops"], 1, "{summary}");
    let log = log(dir.path());
    assert_eq!(
        log.matches("resumed from its checkpoint").count(),
        3,
        "{log}"
    );
    for word in ["[abort]", "[resync]", "[drop]", "all stacked"] {
        assert!(log.contains(word), "no {word} in\n{log}");
    }
}

/// The same disturbances by the clock find each policy at something else, and
/// the stack is the same in the end.
#[test]
#[ignore = "slow: .ci/long"]
fn one_script_of_disturbances_ends_in_one_stack_whatever_the_policy() {
    let script = r#"
{"at_s": 4.5, "do": "drag", "object": "red_cube", "to": [0.40, 0.0, 0.025]}
{"at_s": 14.0, "do": "drag", "object": "blue_cube", "to": [0.45, -0.05, 0.025]}
{"at_s": 21.0, "do": "drag", "object": "red_cube", "to": [0.62, -0.15, 0.025]}
"#;
    let dir = base();
    for policy in ["fsm", "ifelse", "bt"] {
        let options = ["--one-process", "--seed", "6", "--policy", policy];
        assert_stacked(&stack(dir.path(), &options, script));
    }
}

#[test]
fn seeds_in_one_process_are_rows_that_end_done() {
    let dir = base();
    for policy in ["fsm", "ifelse", "bt"] {
        let said: Said = finish(robocell(
            dir.path(),
            &[
                "eval",
                "franka-stack",
                "--seeds",
                "1..3",
                "--policy",
                policy,
                "--jobs",
                "2",
                "--json",
            ],
        ));
        assert_eq!(said.code, 0, "{said:?}");
        let rows: Vec<Value> = said
            .stdout
            .lines()
            .map(|l| serde_json::from_str(l).expect("a row"))
            .collect();
        let (all, rows) = rows.split_last().expect("a summary");
        assert_eq!(rows.len(), 3);
        rows.iter().for_each(assert_stacked);
        assert_eq!(
            (&all["runs"], &all["done"]),
            (&3.into(), &3.into()),
            "{all}"
        );
    }
}

#[test]
fn an_arm_of_the_users_own_follows_the_target() {
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/ur10");
    let dir = base();
    let path = |name: &str| files.join(name).display().to_string();
    let (urdf, xrdf, tuning) = (
        path("ur10.urdf"),
        path("ur10.xrdf"),
        path("ur10_rmpflow.yaml"),
    );
    let script = dir.path().join("target.jsonl");
    let line = r#"{"at_s": 0.5, "do": "target", "position": [0.5, 0.4, 0.5]}"#;
    std::fs::write(&script, line).expect("the script is written");
    let script = script.display().to_string();
    let said = finish(robocell(
        dir.path(),
        &[
            "run",
            "reach",
            "--robot",
            &urdf,
            "--xrdf",
            &xrdf,
            "--rmpflow",
            &tuning,
            "--headless",
            "--speed",
            "max",
            "--until-done",
            "--timeout",
            "8",
            "--json",
            "--script",
            &script,
        ],
    ));
    // Following never ends by itself, so the time limit does.
    assert_eq!(said.code, 5, "{said:?}");
    let summary = said.json();
    assert_eq!(
        (&summary["outcome"], &summary["limit_violations"]),
        (&"timeout".into(), &0.into())
    );
    assert_eq!(summary["script_left"], 0, "{summary}");
}
