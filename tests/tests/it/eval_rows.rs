//! Rows of many episodes: shards, kills, and episodes that cannot be finished.

use std::fs;
use std::path::Path;
use std::process::Stdio;

use cell_rt::process::{SIGINT, SIGKILL, kill};
use robocell_tests::cell::base;
use robocell_tests::program::{Said, finish, robocell, wait_for};
use robocell_tests::random;
use serde_json::Value;

const SEEDS: &str = "1..6";

fn eval(dir: &Path, out: &str, options: &[&str]) -> Said {
    eval_seeds(dir, SEEDS, out, options)
}

fn eval_seeds(dir: &Path, seeds: &str, out: &str, options: &[&str]) -> Said {
    let out = dir.join(out).display().to_string();
    let mut arguments = vec!["eval", "cube", "--seeds", seeds, "--out", &out];
    arguments.extend(options);
    finish(robocell(dir, &arguments))
}

fn rows(dir: &Path, file: &str) -> Vec<Value> {
    let text = fs::read_to_string(dir.join(file)).unwrap();
    let rows = text.lines().map(|line| serde_json::from_str(line).unwrap());
    rows.collect()
}

fn merge(dir: &Path, files: &[&str]) -> Said {
    let files = files
        .iter()
        .map(|file| dir.join(file).display().to_string());
    let files: Vec<String> = files.collect();
    let mut arguments = vec!["eval", "merge"];
    arguments.extend(files.iter().map(String::as_str));
    finish(robocell(dir, &arguments))
}

#[test]
fn shards_merge_to_the_bytes_of_an_unsharded_run() {
    let dir = base();
    let dir = dir.path();
    let whole = eval(dir, "whole.jsonl", &["--jobs", "2"]);
    assert_eq!(whole.code, 0, "{whole:?}");
    assert!(whole.stdout.contains("6 of 6 rows"), "{whole:?}");
    for (file, shard) in [("1.jsonl", "1/2"), ("2.jsonl", "2/2")] {
        assert_eq!(eval(dir, file, &["--shard", shard]).code, 0);
    }
    let merged = merge(dir, &["2.jsonl", "1.jsonl"]);
    assert_eq!(merged.code, 0, "{merged:?}");
    assert_eq!(
        merged.stdout,
        fs::read_to_string(dir.join("whole.jsonl")).unwrap()
    );
    let refused = merge(dir, &["1.jsonl"]);
    assert_eq!((refused.code, refused.stdout.as_str()), (3, ""));
    assert!(
        refused.stderr.contains("shard 2/2 is missing"),
        "{refused:?}"
    );
    // The same command has nothing left to do.
    let again = eval(dir, "whole.jsonl", &[]);
    assert!(
        again.code == 0 && again.stdout.contains("0 episodes now"),
        "{again:?}"
    );
    // Another one is told.
    let other = eval(dir, "whole.jsonl", &["--timeout", "3"]);
    assert_eq!(other.code, 3, "{other:?}");
    assert!(
        other.stderr.contains("started with another input"),
        "{other:?}"
    );
}

/// How many times it is killed; `ROBOCELL_EVAL_KILLS` for a long series.
fn kills() -> u32 {
    let asked = std::env::var("ROBOCELL_EVAL_KILLS").ok();
    asked.map_or(3, |text| text.parse().expect("a number"))
}

#[test]
fn a_kill_at_any_instant_loses_no_row_that_was_written() {
    let dir = base();
    let dir = dir.path();
    assert_eq!(eval(dir, "whole.jsonl", &["--jobs", "2"]).code, 0);
    let out = dir.join("killed.jsonl");
    let file = out.display().to_string();
    let arguments = [
        "eval", "cube", "--seeds", SEEDS, "--out", &file, "--jobs", "2",
    ];
    let mut state = 7;
    let count = || fs::read_to_string(&out).map_or(0, |text| text.lines().count());
    for _ in 0..kills() {
        let mut child = robocell(dir, &arguments)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // At some instant after the next row, or before one.
        let wanted = count() + usize::from(random(&mut state) < 0.5);
        let mut looks = 200.0 * random(&mut state);
        wait_for("an instant", || {
            looks -= 1.0;
            let ended = child.try_wait().unwrap().is_some();
            (ended || (count() >= wanted && looks <= 0.0)).then_some(())
        });
        kill(child.id(), SIGKILL).ok();
        child.wait().unwrap();
    }
    // Ctrl-C ends it, and the message says how many rows are left.
    let child = robocell(dir, &arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (before, whole) = (count(), 6);
    wait_for("a row", || {
        (count() > before || count() == whole).then_some(())
    });
    kill(child.id(), SIGINT).ok();
    let said = child.wait_with_output().unwrap();
    let words = String::from_utf8_lossy(&said.stderr);
    match said.status.code() {
        Some(130) => assert!(words.contains("the same command resumes"), "{words}"),
        code => assert_eq!((code, count()), (Some(0), whole), "{words}"),
    }
    let end = finish(robocell(dir, &arguments));
    assert_eq!(end.code, 0, "{end:?}");
    let read = |name: &str| fs::read(dir.join(name)).unwrap();
    assert!(read("killed.jsonl") == read("whole.jsonl"));
}

#[test]
fn an_episode_that_cannot_begin_and_one_out_of_time_are_rows() {
    let dir = base();
    let dir = dir.path();
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cells");
    fs::create_dir_all(dir.join("cells/cube")).unwrap();
    for file in fs::read_dir(checkout.join("cube")).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), dir.join("cells/cube").join(file.file_name())).unwrap();
    }
    // Where the cube starts inside of the post in some episodes.
    let post = "\n[[fixture]]\nname = \"post\"\nshape = { kind = \"box\", size_m = [0.2, 0.02, 0.1] }\n\
                position_m = [0.5, -0.28, 0.05]\nfriction = 0.5\nobstacle = false\n\
                colour = [0.5, 0.5, 0.5]\n\n[task]\n";
    let cell = fs::read_to_string(checkout.join("cube.toml")).unwrap();
    fs::write(
        dir.join("cells/cube.toml"),
        cell.replacen("\n[task]\n", post, 1),
    )
    .unwrap();
    let data = dir.display().to_string();
    let said = eval(
        dir,
        "rows.jsonl",
        &["--data", &data, "--timeout", "2", "--jobs", "2"],
    );
    assert_eq!(said.code, 0, "{said:?}");
    let rows = rows(dir, "rows.jsonl");
    let seeds: Vec<u64> = rows
        .iter()
        .map(|row| row["seed"].as_u64().unwrap())
        .collect();
    assert_eq!(seeds, [1, 2, 3, 4, 5, 6]);
    let of = |outcome: &str| rows.iter().filter(|row| row["outcome"] == outcome).count();
    assert!(of("error") > 0 && of("timeout") > 0, "{rows:?}");
    assert_eq!(of("error") + of("timeout"), 6, "{rows:?}");
    let reasons = rows.iter().filter(|row| row["outcome"] == "error");
    for row in reasons {
        assert!(
            row["reason"].as_str().unwrap().contains("inside 'post'"),
            "{row}"
        );
    }
}

#[test]
fn a_failed_seed_is_recorded_and_the_page_of_a_report_has_the_command_that_runs_it_again() {
    let dir = base();
    let dir = dir.path();
    let kept = dir.join("failures").display().to_string();
    let options = ["--timeout", "2", "--record-failures", &kept];
    let said = eval_seeds(dir, "3..4", "rows.jsonl", &options);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.stdout.contains("recorded 2 failed"), "{said:?}");
    let recording = dir.join("failures/seed-3.mcap").display().to_string();
    let verified = finish(robocell(dir, &["replay", &recording, "--verify"]));
    assert_eq!(verified.code, 0, "{verified:?}");
    // What was recorded is kept.
    fs::remove_file(&recording).unwrap();
    let again = eval_seeds(dir, "3..4", "rows.jsonl", &options);
    assert!(again.stdout.contains("recorded 1 failed"), "{again:?}");
    let [file, page] = ["rows.jsonl", "page.html"].map(|name| dir.join(name).display().to_string());
    let said = finish(robocell(dir, &["eval", "report", &file, "--html", &page]));
    assert_eq!(said.code, 0, "{said:?}");
    let page = fs::read_to_string(page).unwrap();
    assert!(
        page.contains("None ended done") && !page.contains("http:"),
        "{page}"
    );
    let command = page.split("<code>robocell ").nth(1).expect("a failed seed");
    let command = command.split("</code>").next().unwrap();
    assert!(
        command.contains("--seed 3 ") && command.contains("--timeout 2"),
        "{command}"
    );
    let words: Vec<&str> = command.split(' ').collect();
    let again = finish(robocell(
        dir,
        &[&words[..], &["--one-process", "--json"]].concat(),
    ));
    let summary: Value = serde_json::from_str(again.stdout.lines().last().unwrap()).unwrap();
    let row = &rows(dir, "rows.jsonl")[0];
    for key in ["outcome", "ticks", "state_hash"] {
        assert_eq!(summary[key], row[key], "{key}: {again:?}");
    }
}
