//! Runs that were recorded, computed again bit for bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use cell_record::{Channel, wire_bytes};
use ipc_types::Decision;
use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{Said, built, finish, robocell};
use robocell_tests::recording::{rewrite, same, verify};
use serde_json::Value;
use tempfile::TempDir;

/// Out of time, or not the same.
const NOT_DONE: i32 = 5;
/// A decision in the middle of the recording.
const ALTERED_TICK: u64 = 2_000;

/// A stack begun and recorded to the returned file.
fn recorded(speed: &str) -> (TempDir, PathBuf) {
    let base = base();
    let file = base.path().join("run.mcap");
    let name = file.display().to_string();
    let mut arguments = vec!["run", "franka-stack", "--headless", "--timeout", "4"];
    arguments.extend(["--speed", speed, "--record", &name]);
    let said = finish(robocell(base.path(), &arguments));
    assert_eq!(said.code, NOT_DONE, "{said:?}");
    (base, file)
}

#[test]
fn a_run_in_lockstep_is_the_same_when_it_is_computed_again() {
    let (base, file) = recorded("max");
    let report = same(&verify(base.path(), &file, &["--json"]));
    // From the first keyframe, at the latest a second after the start.
    assert!(
        report["commands"]["compared"].as_u64() > Some(2_500),
        "{report}"
    );
    assert!(
        report["decisions"]["compared"].as_u64() > Some(250),
        "{report}"
    );
}

#[test]
fn a_run_in_real_time_is_the_same_when_it_is_computed_again() {
    let (base, file) = recorded("1");
    let report = same(&verify(base.path(), &file, &["--json"]));
    // A busy machine leaves gaps, and each costs up to a second.
    assert!(
        report["commands"]["compared"].as_u64() > Some(0),
        "{report}"
    );
    assert!(
        report["decisions"]["compared"].as_u64() > Some(0),
        "{report}"
    );
}

#[test]
fn one_altered_decision_is_found_at_its_tick() {
    let (base, file) = recorded("max");
    let altered = base.path().join("altered.mcap");
    let mut count = 0;
    let unchanged = |_: &mut Value| {};
    rewrite(&file, &altered, unchanged, |entry| {
        if entry.channel == Channel::Decision && entry.tick == ALTERED_TICK {
            let mut decision: Decision = entry.read().expect("a decision");
            decision.goals[0].target.position[2] += 1.0e-9;
            entry.bytes = wire_bytes(&decision).to_vec();
            count += 1;
        }
    });
    assert_eq!(count, 1, "decisions at tick {ALTERED_TICK}");
    let said = verify(base.path(), &altered, &["--json"]);
    assert_eq!(said.code, NOT_DONE, "{said:?}");
    let said = said.json();
    let first = &said["report"]["first_difference"];
    assert_eq!(
        (
            &said["verdict"],
            &first["message"],
            &first["tick"],
            &first["field"]
        ),
        (
            &"different".into(),
            &"decision".into(),
            &ALTERED_TICK.into(),
            &"goals[0].target.position[2]".into()
        ),
        "{said}"
    );
    let told = verify(base.path(), &altered, &[]);
    assert_eq!(told.code, NOT_DONE);
    let wanted = format!("DIFFERENT first at tick {ALTERED_TICK}: decision");
    assert!(told.stdout.contains(&wanted), "{told:?}");
    let chart = format!("goals[0].target.position[2] around tick {ALTERED_TICK}:");
    for part in [&chart, "# the same", "computed minus recorded", "2.0 s"] {
        assert!(told.stdout.contains(part), "{part}: {}", told.stdout);
    }
}

#[test]
fn what_is_recorded_of_a_paused_cell_can_be_verified() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--speed", "max", "--paused"]);
    cell.wait_up();
    let file = cell.base().join("later.mcap");
    let name = file.display().to_string();
    assert_eq!(cell.ask(&["record", "start", &name]).code, 0);
    assert_eq!(cell.ask(&["task", "start"]).code, 0);
    assert_eq!(cell.ask(&["step", "2500"]).code, 0);
    cell.wait_status("the end of the steps", |status| {
        status["paused"] == true && status["sim_time_s"].as_f64() > Some(2.49)
    });
    assert_eq!(cell.ask(&["record", "stop"]).code, 0);
    same(&verify(cell.base(), &file, &["--json"]));
    // The ring, while the cell runs.
    same(&verify(
        cell.base(),
        &cell.run_dir().join("flight"),
        &["--json"],
    ));
}

/// `robocell run ...` recording to a file system of 2 MB, which is its own.
fn with_a_small_disk(base: &Path, arguments: &[&str]) -> Option<Said> {
    let small = base.join("small");
    fs::create_dir(&small).unwrap();
    let works = |command: &mut Command| {
        let said = command.args(["true"]).output();
        said.is_ok_and(|said| said.status.success())
    };
    let flags = ["-m", "-rm"]
        .into_iter()
        .find(|flags| works(Command::new("unshare").arg(flags)))?;
    let script = "small=$1; kept=$2; shift 2; \
        mount -t tmpfs -o size=2m small $small || exit 99; \
        \"$@\" --record $small/run.mcap; code=$?; cp $small/run.mcap $kept; exit $code";
    let mut command = Command::new("unshare");
    command
        .args([flags, "sh", "-c", script, "sh"])
        .args([&small, &base.join("kept.mcap")])
        .arg(built("robocell"))
        .args(arguments)
        .env("ROBOCELL_RUN_DIR", base);
    Some(finish(command)).filter(|said| said.code != 99)
}

#[test]
fn a_full_disk_ends_the_file_and_nothing_else() {
    let base = base();
    let arguments = ["run", "franka-stack", "--headless", "--speed", "max"];
    let arguments = [&arguments[..], &["--timeout", "12", "--json"]].concat();
    let Some(said) = with_a_small_disk(base.path(), &arguments) else {
        eprintln!("skipped: this user may not mount a file system of his own");
        return;
    };
    assert_eq!(said.code, NOT_DONE, "{said:?}");
    let untouched = finish(robocell(base.path(), &arguments)).json();
    let said = said.json();
    for key in ["sim_time_s", "state_hash", "placed", "missed_cycles"] {
        assert_eq!(said[key], untouched[key], "{key}: {said}");
    }
    let kept = base.path().join("kept.mcap");
    assert!(fs::metadata(&kept).unwrap().len() > 1_000_000);
    let report = same(&verify(base.path(), &kept, &["--json"]));
    let last = report["ticks"][1].as_u64().expect("ticks");
    assert!((1_500..12_000).contains(&last), "{report}");
}
