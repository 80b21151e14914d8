//! A task program from another repository: it runs as the task of a cell, survives
//! SIGKILL, is recorded and computed again; and one with defects is answered
//! with one clear line while the arm holds.

use std::path::{Path, PathBuf};

use robocell_tests::cell::{TestCell, base};
use robocell_tests::fault::kill_and_wait;
use robocell_tests::program::{Said, example, finish, robocell};
use robocell_tests::recording::{same, verify};

/// The folder with the circle's cell.
fn circle_data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/cell/task-program/examples/circle")
}

/// `robocell run circle` by the example's program, to its end.
fn circle(base: &Path, more: &[&str]) -> Said {
    let (data, program) = (circle_data(), example("circle"));
    let mut arguments = vec!["run", "circle", "--data", data.to_str().unwrap()];
    arguments.extend(["--task", program.to_str().unwrap(), "--headless"]);
    arguments.extend(["--speed", "max", "--until-done", "--json"]);
    arguments.extend(more);
    finish(robocell(base, &arguments))
}

#[test]
fn does_its_job_in_one_process_and_in_four_killed_or_not() {
    let base = base();
    let script = base.path().join("kill.jsonl");
    let kill = |at: u32| format!(r#"{{"at_s": {at}.7, "do": "kill", "process": "task"}}"#);
    let kills: Vec<String> = (1..=4).map(kill).collect();
    std::fs::write(&script, kills.join("\n")).unwrap();
    let script = script.to_str().unwrap();
    let calm = circle(base.path(), &["--one-process"]).json();
    assert_eq!(calm["outcome"], "done", "{calm}");
    for more in [&[][..], &["--script", script]] {
        let four = circle(base.path(), more).json();
        assert_eq!(four["outcome"], "done", "{four}");
        assert_eq!(four["state_hash"], calm["state_hash"], "{four}");
        assert_eq!(four["limit_violations"], 0, "{four}");
    }
}

#[test]
fn is_recorded_and_computed_again_by_itself() {
    let base = base();
    let file = base.path().join("circle.mcap");
    let said = circle(base.path(), &["--record", file.to_str().unwrap()]);
    assert_eq!(said.code, 0, "{said:?}");
    let report = same(&verify(base.path(), &file, &["--json"]));
    assert!(
        report["decisions"]["compared"].as_u64() > Some(500),
        "{report}"
    );
}

#[test]
fn brings_a_controller_that_moves_the_arm_in_one_process_and_in_four() {
    let base = base();
    let data =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/cell/task-program/examples/sway");
    let program = example("sway");
    let folder = program.parent().unwrap().display().to_string();
    let path = format!("{folder}:{}", std::env::var("PATH").unwrap_or_default());
    let file = base.path().join("sway.mcap");
    let run = |more: &[&str]| {
        let mut arguments = vec!["run", "sway", "--data", data.to_str().unwrap()];
        arguments.extend(["--task", program.to_str().unwrap(), "--headless"]);
        arguments.extend(["--speed", "max", "--until-done", "--json"]);
        arguments.extend(more);
        let mut command = robocell(base.path(), &arguments);
        // The cell file names the program of the arm, which is looked up.
        command.env("PATH", &path);
        finish(command)
    };
    let one = run(&["--one-process"]).json();
    assert_eq!(one["outcome"], "done", "{one}");
    let four = run(&["--record", file.to_str().unwrap()]).json();
    assert_eq!(four["state_hash"], one["state_hash"], "{four}");
    assert_eq!(four["limit_violations"], 0, "{four}");
    let report = same(&verify(base.path(), &file, &["--json"]));
    assert!(
        report["commands"]["compared"].as_u64() > Some(5000),
        "{report}"
    );
}

#[test]
fn answers_for_its_own_jobs() {
    let base = base();
    let program = example("circle");
    let program = program.to_str().unwrap();
    let data = circle_data();
    let data = data.to_str().unwrap();
    let ask = |arguments: &[&str]| finish(robocell(base.path(), arguments));
    let said = ask(&["fsm", "show", "circle", "--data", data, "--task", program]);
    assert!(said.stdout.contains("circle"), "{said:?}");
    let said = ask(&["schema", "cell", "--task", program]);
    assert!(said.stdout.contains("\"const\": \"circle\""), "{said:?}");
    let said = ask(&[
        "eval", "circle", "--seeds", "1..2", "--data", data, "--task", program,
    ]);
    assert!(said.stdout.contains("2 of 2 done"), "{said:?}");
    // The built-in program does not know the kind.
    let said = ask(&["run", "circle", "--data", data, "--headless"]);
    assert_eq!(said.code, 3, "{said:?}");
    assert!(
        said.stderr
            .contains("task.kind is 'circle', which this task program does not know"),
        "{said:?}"
    );
}

/// A folder with a cell for the program with defects.
fn defect_cell(dir: &Path, defect: &str) {
    std::fs::create_dir_all(dir.join("cells")).unwrap();
    let text = std::fs::read_to_string(circle_data().join("cells/circle.toml")).unwrap();
    let text = text.replace("\"circle\"", &format!("\"{defect}\""));
    std::fs::write(dir.join("cells/defect.toml"), text).unwrap();
}

/// A run of the program with that defect, to its end.
fn run_defect(base: &Path, defect: &str, more: &[&str]) -> Said {
    defect_cell(base, defect);
    let program = example("misbehaving");
    let mut arguments = vec!["run", "defect", "--data", base.to_str().unwrap()];
    arguments.extend(["--task", program.to_str().unwrap(), "--headless"]);
    arguments.extend(["--until-done", "--json", "--timeout", "8"]);
    arguments.extend(more);
    finish(robocell(base, &arguments))
}

#[test]
fn that_decides_nonsense_fails_with_its_reason() {
    for defect in ["not_a_number", "out_of_this_world"] {
        let base = base();
        let said = run_defect(base.path(), defect, &["--speed", "max"]);
        let summary = said.json();
        assert_eq!(said.code, 5, "{said:?}");
        assert_eq!(summary["outcome"], "failed", "{summary}");
        assert_eq!(summary["reason"], "invalid_decision", "{summary}");
        assert_eq!(summary["limit_violations"], 0, "{summary}");
    }
}

#[test]
fn that_ends_again_and_again_is_given_up_with_its_last_words() {
    for (defect, words) in [
        ("panics", "the policy has a defect"),
        ("exits", "the policy ends its process"),
        ("exits_with_0", "the policy ends its process"),
    ] {
        let base = base();
        let said = run_defect(base.path(), defect, &[]);
        assert_eq!(said.code, 6, "{said:?}");
        let last = said.stderr.split("Its last words:").nth(1);
        assert!(last.is_some_and(|last| last.contains(words)), "{said:?}");
    }
}

#[test]
fn that_ends_its_process_in_one_process_is_not_done_whatever_its_exit_code() {
    for (defect, code) in [("exits", 1), ("exits_with_0", 0), ("exits_with_5", 5)] {
        let base = base();
        let said = run_defect(base.path(), defect, &["--one-process"]);
        assert_eq!(said.code, 6, "{said:?}");
        let words = format!("ended with exit status: {code} before the end of the run");
        assert!(said.stderr.contains(&words), "{said:?}");
    }
}

#[test]
fn that_is_missing_is_named_with_where_it_was_looked_for() {
    let base = base();
    defect_cell(base.path(), "exits");
    let data = base.path().to_str().unwrap();
    let mut arguments = vec!["run", "defect", "--data", data, "--headless", "--task"];
    arguments.push("no_such_program");
    let said = finish(robocell(base.path(), &arguments));
    assert_eq!(said.code, 3, "{said:?}");
    assert_eq!(said.stderr.lines().count(), 1, "{said:?}");
    for words in ["'no_such_program' is missing", "cells", "PATH"] {
        assert!(said.stderr.contains(words), "{said:?}");
    }
}

#[test]
fn that_hangs_is_killed_and_given_up_while_the_arm_holds() {
    let base = base();
    defect_cell(base.path(), "hangs");
    let program = example("misbehaving");
    let data = base.path().display().to_string();
    let mut cell = TestCell::start(&[
        "defect",
        "--data",
        &data,
        "--task",
        program.to_str().unwrap(),
        "--headless",
    ]);
    let said = cell.wait_end();
    assert_eq!(said.code, 6, "{said:?}");
    assert!(said.stderr.contains("task"), "{said:?}");
}

#[test]
fn that_was_built_anew_and_remembers_something_else_starts_without_a_checkpoint() {
    let base = base();
    let program = base.path().join("program");
    std::fs::copy(example("circle"), &program).unwrap();
    let (data, path) = (circle_data(), program.to_str().unwrap().to_owned());
    let arguments = ["circle", "--data", data.to_str().unwrap(), "--task", &path];
    let more = ["--headless", "--until-done"];
    let mut cell = TestCell::start_in(base, &[&arguments[..], &more].concat());
    cell.wait_up();
    let rebuilt = program.with_extension("new");
    std::fs::copy(example("misbehaving"), &rebuilt).unwrap();
    std::fs::rename(&rebuilt, &program).unwrap();
    kill_and_wait(&cell, "task");
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    let log = |name: &str| std::fs::read_to_string(cell.run_dir().join("logs").join(name));
    let warnings = log("task.log").unwrap();
    let warned = warnings
        .matches("the task's checkpoint cannot be read")
        .count();
    assert_eq!(warned, 1, "{warnings}");
    let trace = log("trace.log").unwrap();
    assert!(trace.contains("started without a checkpoint"), "{trace}");
}

#[test]
fn the_guide_quotes_the_example_that_is_built_and_run() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let guide = std::fs::read_to_string(root.join("docs/task-in-rust.md")).unwrap();
    let code = root.join("crates/cell/task-program/examples/circle.rs");
    assert!(guide.contains(&std::fs::read_to_string(code).unwrap()));
}
