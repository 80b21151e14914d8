//! Numbers of a cell that an evaluation replaces: sweeps, draws, disturbances, and the search
//! for the least one that breaks a task.

use std::fs;
use std::path::Path;

use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell};
use serde_json::Value;

fn eval(dir: &Path, out: &str, options: &[&str]) -> Said {
    let out = dir.join(out).display().to_string();
    let words = ["eval", "cube", "--out", &out, "--jobs", "2"];
    finish(robocell(dir, &[&words[..], options].concat()))
}

fn rows(dir: &Path, file: &str) -> Vec<Value> {
    let text = fs::read_to_string(dir.join(file)).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str(line).unwrap());
    rows.collect()
}

/// The summary of `robocell run cube` with these words.
fn run(dir: &Path, words: &[&str]) -> Value {
    let said = finish(robocell(
        dir,
        &[&["run", "cube", "--until-done", "--json"], words].concat(),
    ));
    let line = said.stdout.lines().last().unwrap_or_default();
    serde_json::from_str(line).unwrap_or_else(|_| panic!("{said:?}"))
}

#[test]
fn every_value_is_run_with_every_seed_and_drawn_numbers_run_again_to_the_same_state() {
    let dir = base();
    let dir = dir.path();
    let options = [
        "--seeds",
        "1..2",
        "--set",
        "time_limit_s=2.5,60",
        "--vary",
        "object.*.mass_kg=0.05..0.2",
        "--vary",
        "disturbance.drive_delay_s=0..0.004",
    ];
    let said = eval(dir, "rows.jsonl", &options);
    assert_eq!(said.code, 0, "{said:?}");
    let rows = rows(dir, "rows.jsonl");
    let of = |key: &str| {
        rows.iter()
            .map(|row| row[key].to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(of("seed"), ["1", "1", "2", "2"]);
    assert_eq!(of("variant"), ["1", "2", "1", "2"]);
    assert_eq!(of("outcome")[..2], ["\"timeout\"", "\"done\""]);
    assert_eq!(rows[1]["set"]["time_limit_s"], 60);
    let drawn = &rows[3]["drawn"];
    assert_eq!(*drawn, rows[2]["drawn"], "drawn for the seed");
    assert_ne!(*drawn, rows[0]["drawn"]);
    let mass = drawn["object.cube.mass_kg"].as_f64().unwrap();
    assert!((0.05..0.2).contains(&mass), "{mass}");
    // The same in one process, and in four with their messages.
    let delay = &drawn["disturbance.drive_delay_s"];
    let set = [
        "time_limit_s=60".to_owned(),
        format!("object.cube.mass_kg={}", drawn["object.cube.mass_kg"]),
        format!("disturbance.drive_delay_s={delay}"),
    ];
    let set: Vec<&str> = set.iter().flat_map(|one| ["--set", one]).collect();
    for way in [&["--one-process"][..], &["--headless", "--speed", "max"]] {
        let summary = run(dir, &[&["--seed", "2"], way, &set].concat());
        assert_eq!(summary["state_hash"], rows[3]["state_hash"], "{way:?}");
    }
    let file = dir.join("rows.jsonl").display().to_string();
    let report = finish(robocell(dir, &["eval", "report", &file]));
    assert!(
        report.stdout.contains("time_limit_s=60  2 of 2"),
        "{report:?}"
    );
}

#[test]
fn a_task_that_is_killed_sees_the_same_noise() {
    let dir = base();
    let dir = dir.path();
    let script = dir.join("kill.jsonl");
    fs::write(
        &script,
        "{\"at_s\": 2.0, \"do\": \"kill\", \"process\": \"task\"}\n",
    )
    .unwrap();
    let script = script.display().to_string();
    let noise = [
        "--seed",
        "3",
        "--set",
        "disturbance.position_noise_m=0.002",
        "--set",
        "disturbance.position_offset_m=0.003",
    ];
    let in_one = run(dir, &[&noise[..], &["--one-process"]].concat());
    let killed = run(
        dir,
        &[
            &noise[..],
            &["--headless", "--speed", "max", "--script", &script],
        ]
        .concat(),
    );
    assert_eq!(
        (&in_one["outcome"], &killed["task_restarts"]),
        (&"done".into(), &1.into())
    );
    assert_eq!(killed["state_hash"], in_one["state_hash"]);
    let without = run(dir, &["--seed", "3", "--one-process"]);
    assert_ne!(without["state_hash"], in_one["state_hash"]);
}

#[test]
fn a_number_that_the_cell_does_not_take_is_refused_before_anything_runs() {
    let dir = base();
    let dir = dir.path();
    for (option, value, part) in [
        (
            "--set",
            "time_limit=4",
            "unknown key 'time_limit'; did you mean 'time_limit_s'?",
        ),
        ("--set", "object.cub.mass_kg=1", "did you mean 'cube'?"),
        (
            "--set",
            "object.cube.mass_kg=0.1,-1",
            "object.0.mass_kg is -1; ",
        ),
        ("--set", "description=4", "description is not a number"),
        ("--vary", "object.cube.mass_kg=0.2..0.1", "LOW below HIGH"),
        ("--vary", "object.*.mas_kg=0.1..0.2", "unknown key 'mas_kg'"),
    ] {
        let said = eval(dir, "rows.jsonl", &["--seeds", "1", option, value]);
        assert!(said.code == 3 || said.code == 2, "{value}: {said:?}");
        assert!(said.stderr.contains(part), "{value}: {said:?}");
        assert!(!dir.join("rows.jsonl").exists(), "{value}");
    }
    let words = [
        "run",
        "cube",
        "--headless",
        "--set",
        "disturbance.drive_delay_s=9",
    ];
    let said = finish(robocell(dir, &words));
    assert_eq!(said.code, 3, "{said:?}");
    assert!(
        said.stderr
            .contains("drive_delay_s is 9; 0 to 1 is allowed"),
        "{said:?}"
    );
}
