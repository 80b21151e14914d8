//! What commands print with `--json` is what `robocell schema output` describes.

use std::path::Path;

use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{Said, finish, robocell, wait_for};
use robocell_tests::schema::differences;
use serde_json::Value;

/// Checks each line of `said` against the schema of the output `name`.
fn check(base: &Path, name: &str, said: &Said) {
    let schema = finish(robocell(base, &["schema", "output", name]));
    assert_eq!(schema.code, 0, "{schema:?}");
    let schema: Value = serde_json::from_str(&schema.stdout).expect("a schema");
    assert!(!said.stdout.is_empty(), "{name}: {said:?}");
    for line in said.stdout.lines() {
        let value: Value = serde_json::from_str(line).unwrap_or_else(|error| {
            panic!("{name}: {error}: {line}");
        });
        assert!(value.is_object(), "{name}: {line}");
        let wrong = differences(&schema, &value);
        assert!(wrong.is_empty(), "{name}: {wrong:#?}\n{line}");
    }
}

/// `robocell WORDS` in `base`, whose output is described as NAME.
pub(crate) fn checked(base: &Path, name: &str, words: &[&str]) -> Said {
    let said = finish(robocell(base, words));
    check(base, name, &said);
    said
}

#[test]
fn outputs_without_a_cell_fit_their_schemas() {
    let base = base();
    let dir = base.path();
    let names = finish(robocell(dir, &["schema", "output"]));
    assert!(
        names.stdout.lines().any(|name| name == "status"),
        "{names:?}"
    );
    checked(dir, "list", &["list", "--json"]);
    checked(dir, "doctor", &["doctor", "--json"]);
    checked(dir, "incidents", &["incident", "--json"]);
    let eval = ["eval", "cube", "--seeds", "2", "--json"];
    let said = checked(dir, "eval", &eval);
    assert_eq!(said.json()["runs"], 2, "{said:?}");
    let broken = dir.join("broken.json");
    std::fs::write(
        &broken,
        "{\"format\": \"behavior-tree/1\", \"name\": \"x\"}",
    )
    .expect("a file");
    let broken = broken.display().to_string();
    let said = checked(dir, "check", &["bt", "check", &broken, "--json"]);
    assert_eq!(
        (said.code, &said.json()["ok"]),
        (3, &Value::Bool(false)),
        "{said:?}"
    );
    let tree = concat!(env!("CARGO_MANIFEST_DIR"), "/../cells/cube/cube.tree.json");
    let said = checked(dir, "check", &["bt", "check", tree, "--json"]);
    assert_eq!(
        (said.code, &said.json()["ok"]),
        (0, &Value::Bool(true)),
        "{said:?}"
    );
}

#[test]
fn outputs_about_a_cell_fit_their_schemas() {
    let mut cell = TestCell::start(&["franka-stack", "--headless", "--json", "--speed", "max"]);
    cell.wait_up();
    cell.wait_status("a placed cube", |status| {
        status["placed"]
            .as_array()
            .is_some_and(|all| !all.is_empty())
    });
    let ask = |name: &str, words: &[&str]| checked(cell.base(), name, words);
    let status = ask("status", &["status", "--json"]).json();
    assert!(status["real_time_factor"].is_number(), "{status}");
    let top = ask("top", &["top", "--json"]).json();
    assert!(
        top["log"].as_array().is_some_and(|log| !log.is_empty()),
        "{top}"
    );
    ask("logs", &["logs", "trace", "--json"]);
    ask("list", &["list", "--json"]);
    let file = cell.base().join("kept.mcap").display().to_string();
    let record = wait_for("a recording", || {
        let said = cell.ask(&["record", "last", "3s", &file, "--json"]);
        (said.code == 0).then_some(said)
    });
    check(cell.base(), "record", &record);
    let refused = cell.ask(&["record", "last", "1s", &file]);
    assert!(
        refused.code == 3 && refused.stderr.contains("exists"),
        "{refused:?}"
    );
    assert_eq!(record.json()["file"], file.as_str(), "{record:?}");
    assert!(
        record.json()["message"]
            .as_str()
            .is_some_and(|said| said.contains(&file))
    );
    let plot = [
        "plot",
        &file,
        "panda/* error",
        "panda/distance to target",
        "panda/gripper width",
        "--json",
    ];
    let plot = ask("plot", &plot).json();
    let signals = plot["signals"].as_array().expect("signals");
    assert_eq!(signals.len(), 9, "{plot}");
    assert!(
        signals[8]["time_s"]
            .as_array()
            .is_some_and(|all| all.len() > 2000),
        "{}",
        signals[8]
    );
    ask("plot", &["plot", &file, "--json"]);
    ask("verify", &["replay", &file, "--verify", "--json"]);
    let pid = status["processes"][0]["pid"].as_u64().expect("a pid");
    cell_rt::process::kill(
        u32::try_from(pid).expect("a pid"),
        cell_rt::process::SIGKILL,
    )
    .expect("a signal");
    wait_for("an incident", || {
        let said = cell.ask(&["incident", "--json"]);
        let is_kept = !said.json()["incidents"].as_array()?.is_empty();
        is_kept.then_some(())
    });
    ask("incidents", &["incident", "--json"]);
    ask("incident", &["incident", "1", "--json"]);
    assert_eq!(cell.ask(&["down"]).code, 0);
    cell.wait_end();
}

#[test]
fn the_end_of_a_run_fits_its_schema() {
    let base = base();
    let words = [
        "run",
        "reach",
        "--one-process",
        "--timeout",
        "0.2",
        "--json",
    ];
    checked(base.path(), "run", &words);
}

#[test]
#[ignore = "slow: .ci/long"]
fn a_bench_and_chaos_fit_their_schemas() {
    let base = base();
    checked(base.path(), "bench", &["bench", "loop", "--json"]);
    let fleet = ["bench", "fleet", "--seconds", "0.2", "--json"];
    let said = checked(base.path(), "bench", &fleet);
    assert_eq!(said.code, 0, "{said:?}");
    for name in [
        "memory of a cell of processes",
        "lockstep, 1 job: per core",
        "episodes of cube, 1 job",
        "reach, start: reset in place",
        "arms: exponent",
        "real time: cells until p99 doubles",
    ] {
        let json = said.json();
        let mut rows = json["rows"].as_array().into_iter().flatten();
        assert!(rows.any(|row| row["name"] == name), "{name}: {said:?}");
    }
    let chaos = ["chaos", "reach", "--minutes", "0.1", "--json"];
    checked(base.path(), "chaos", &chaos);
}
