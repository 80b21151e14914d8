//! A project of the user's own, made by `robocell new` in an empty folder: the
//! first command of its README works, its task survives SIGKILL mid-carry, and
//! its recording is computed again.

use std::path::{Path, PathBuf};
use std::process::Command;

use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use robocell_tests::recording::same;

/// The arm carries the cube then (s).
const MID_CARRY: &str = r#"{"at_s": 3.5, "do": "kill", "process": "task"}"#;

/// `robocell new` in `base`; the project's folder.
fn project(base: &Path, name: &str, way: &str) -> PathBuf {
    let mut command = robocell(base, &["new", name, "--as", way]);
    command.current_dir(base);
    let said = finish(command);
    assert_eq!(said.code, 0, "{said:?}");
    base.join(name)
}

/// The commands of a README.
fn commands(project: &Path) -> Vec<String> {
    let readme = std::fs::read_to_string(project.join("README.md")).unwrap();
    assert!(readme.lines().count() <= 16, "{readme}");
    let lines = readme.lines().filter_map(|line| line.strip_prefix("    "));
    lines.map(str::to_owned).collect()
}

/// The command of a README that starts with `robocell`, in the project's folder
/// and with `more` options.
fn say(project: &Path, command: &str, more: &[&str], prepare: impl Fn(&mut Command)) -> Said {
    let words = command.strip_prefix("robocell ").unwrap();
    let arguments: Vec<&str> = words.split(' ').chain(more.iter().copied()).collect();
    let mut command = robocell(project.parent().unwrap(), &arguments);
    command.current_dir(project);
    prepare(&mut command);
    finish(command)
}

/// In one process, in four, and in four with the task killed mid-carry: the same
/// end, to the bit; and the recording of the last one is computed again.
fn assert_runs(project: &Path, prepare: impl Fn(&mut Command)) {
    let run = commands(project).first().unwrap().clone();
    let script = project.join("kill.jsonl");
    std::fs::write(&script, MID_CARRY).unwrap();
    let mut hashes = Vec::new();
    for more in [
        &["--one-process"][..],
        &["--headless", "--speed", "max"],
        &[
            "--headless",
            "--speed",
            "max",
            "--script",
            "kill.jsonl",
            "--record",
            "run.mcap",
        ],
    ] {
        let said = say(project, &run, &[more, &["--json"]].concat(), &prepare);
        let summary = said.json();
        assert_eq!(summary["outcome"], "done", "{more:?} {said:?}");
        assert_eq!(summary["placed"], serde_json::json!(["cube"]), "{summary}");
        assert_eq!(summary["drops"], 0, "{summary}");
        assert_eq!(summary["limit_violations"], 0, "{summary}");
        hashes.push(summary["state_hash"].clone());
        if more.contains(&"--record") {
            assert_eq!(summary["task_restarts"], 1, "{summary}");
        }
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    let verified = say(
        project,
        "robocell replay run.mcap --verify --json",
        &[],
        &prepare,
    );
    let report = same(&verified);
    assert!(
        report["decisions"]["compared"].as_u64() > Some(300),
        "{report}"
    );
}

fn assert_file_project_runs(way: &str) {
    let base = base();
    let project = project(base.path(), "mine", way);
    assert_runs(&project, |_| {});
    let test = commands(&project).get(1).unwrap().clone();
    let said = say(&project, &test, &[], |_| {});
    assert!(said.stdout.contains("5 of 5 done"), "{said:?}");
}

#[test]
fn without_a_compiler_runs_is_killed_and_is_recorded() {
    assert_file_project_runs("table");
}

#[test]
#[ignore = "slow: .ci/long"]
fn in_the_other_kinds_of_file_does_so_too() {
    assert_file_project_runs("json");
    assert_file_project_runs("matrix");
}

#[test]
#[ignore = "compiles a project outside of the workspace for minutes: .ci/long"]
fn in_rust_is_built_runs_is_killed_and_is_recorded() {
    // Kept from run to run, and not where `robocell` would look for the program.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("new-project");
    for way in ["fsm", "ifelse", "tree"] {
        let base = base();
        let project = project(base.path(), "mine", way);
        let prepare = |command: &mut Command| {
            command.env("CARGO_TARGET_DIR", &target);
        };
        let run = commands(&project).first().unwrap().clone();
        // The first start compiles, which takes longer than any test waits.
        let build = Command::new("cargo")
            .args(["build", "--release", "--quiet"])
            .current_dir(&project)
            .env("CARGO_TARGET_DIR", &target)
            .status();
        assert!(build.unwrap().success(), "{run}");
        assert_runs(&project, prepare);
        let test = commands(&project).get(1).unwrap().clone();
        let mut words = test.split(' ');
        let tested = Command::new(words.next().unwrap())
            .args(words)
            .current_dir(&project)
            .env("CARGO_TARGET_DIR", &target)
            .status();
        assert!(tested.unwrap().success(), "{test}");
    }
}

#[test]
fn has_a_good_name_and_a_folder_of_its_own() {
    let base = base();
    let ask = |name: &str| {
        let mut command = robocell(base.path(), &["new", name, "--as", "json"]);
        command.current_dir(base.path());
        finish(command)
    };
    for name in ["Mine", "../mine", "9mine", "test", ""] {
        let said = ask(name);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.stderr.contains("cannot be the name"), "{said:?}");
    }
    assert_eq!(ask("mine").code, 0);
    let said = ask("mine");
    assert_eq!(said.code, 3, "{said:?}");
    assert!(said.stderr.contains("mine exists"), "{said:?}");
}
