//! Physics that was killed continues from its state of a moment ago.

use robocell_tests::cell::{TestCell, base, generation};
use robocell_tests::fault::kill_and_wait;
use serde_json::Value;

fn seconds(status: &Value) -> f64 {
    status["sim_time_s"].as_f64().unwrap_or(0.0)
}

#[test]
fn a_job_is_finished_though_physics_is_killed_in_the_middle_of_it() {
    let base = base();
    let script = base.path().join("script.jsonl");
    let lines = r#"{"at_phase": "LIFT", "nth": 2, "do": "kill", "process": "physics"}
{"at_phase": "RELEASE", "nth": 3, "do": "kill", "process": "physics"}"#;
    std::fs::write(&script, lines).unwrap();
    let script = script.to_str().unwrap().to_owned();
    let recording = base.path().join("run.mcap").to_str().unwrap().to_owned();
    let mut arguments = "franka-stack --headless --until-done --json --speed max --timeout 200"
        .split(' ')
        .collect::<Vec<_>>();
    arguments.extend(["--script", &script, "--record", &recording]);
    let mut cell = TestCell::start_in(base, &arguments);
    let said = cell.wait_end();
    assert_eq!(said.code, 0, "{said:?}");
    let summary = said.json();
    assert_eq!(summary["placed"].as_array().unwrap().len(), 4, "{summary}");
    assert_eq!(summary["limit_violations"], 0, "{summary}");
    assert_eq!(summary["script_left"], 0, "{summary}");
    let log = std::fs::read_to_string(cell.run_dir().join("logs/task.log")).unwrap_or_default();
    let log = log + &cell.ask(&["logs"]).stdout;
    assert_eq!(
        log.matches("resumed where physics resumed").count(),
        2,
        "{log}"
    );
    let said = cell.ask(&["replay", &recording, "--verify", "--json"]);
    let verdict = said.json();
    assert_eq!(verdict["verdict"], "same", "{verdict}");
}

#[test]
fn a_paused_cell_stays_paused_at_its_tick_when_physics_is_killed() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_status("two seconds", |status| seconds(status) > 2.0);
    assert_eq!(cell.ask(&["pause"]).code, 0);
    let before = cell.wait_status("a pause", |status| status["paused"] == true);
    kill_and_wait(&cell, "physics");
    let after = cell.wait_status("a state of the new physics", |status| {
        generation(status, "physics") > 1 && status["sim_time_s"].is_number()
    });
    assert_eq!(after["paused"], true);
    assert_eq!(after["tick"], before["tick"]);
    assert_eq!(cell.ask(&["resume"]).code, 0);
    cell.wait_status("time", |status| seconds(status) > seconds(&before) + 0.5);
}

#[test]
fn a_run_that_lost_processes_counts_them_and_names_all_parts_of_its_recording() {
    let base = base();
    let script = base.path().join("script.jsonl");
    let lines = r#"{"at_s": 1, "do": "kill", "process": "monitor"}
{"at_s": 2, "do": "kill", "process": "physics"}"#;
    std::fs::write(&script, lines).unwrap();
    let script = script.to_str().unwrap().to_owned();
    let folder = base.path().join("a folder");
    std::fs::create_dir(&folder).unwrap();
    let parts = ["run.mcap", "run-part2.mcap"].map(|name| folder.join(name));
    let mut arguments = "reach --headless --speed max --timeout 4"
        .split(' ')
        .collect::<Vec<_>>();
    let file = parts[0].to_str().unwrap().to_owned();
    arguments.extend(["--script", &script, "--record", &file]);
    let mut cell = TestCell::start_in(base, &arguments);
    let said = cell.wait_end();
    assert!(!said.stdout.contains("nothing had to be"), "{said:?}");
    for words in ["1 physics restart", "1 monitor restart"] {
        assert!(said.stdout.contains(words), "{said:?}");
    }
    for part in &parts {
        assert!(part.is_file(), "{}", part.display());
        let hint = format!("`robocell replay '{}'`", part.display());
        assert!(said.stdout.contains(&hint), "no {hint} in {said:?}");
    }
}

/// The note of a process in `status`.
fn note(status: &Value, process: &str) -> String {
    let processes = status["processes"].as_array().into_iter().flatten();
    let mut of_it = processes.filter(|one| one["name"] == process);
    let note = of_it.next().and_then(|one| one["note"].as_str());
    note.unwrap_or_default().to_owned()
}

#[test]
fn a_damaged_state_or_checkpoint_is_a_fault_in_the_status_and_in_the_summary() {
    let mut cell = TestCell::start(&["franka-stack", "--headless", "--json"]);
    cell.wait_status("two seconds", |status| seconds(status) > 2.0);
    // Nothing is written while the cell is paused.
    assert_eq!(cell.ask(&["pause"]).code, 0);
    cell.wait_status("a pause", |status| status["paused"] == true);
    let nonsense = vec![0xa5; 4_000];
    for (file, process, named) in [
        ("task.slots", "task", "which is damaged"),
        ("physics.state", "physics", "from the state before"),
    ] {
        let path = cell.run_dir().join(file);
        let file = std::fs::OpenOptions::new().write(true).open(path).unwrap();
        std::os::unix::fs::FileExt::write_at(&file, &nonsense, 24).unwrap();
        kill_and_wait(&cell, process);
        assert_eq!(cell.ask(&["resume"]).code, 0);
        cell.wait_status("a fault", |status| note(status, process).contains(named));
        assert_eq!(cell.ask(&["pause"]).code, 0);
    }
    assert_eq!(cell.ask(&["down"]).code, 0);
    let summary = cell.wait_end().json();
    let faults = summary["faults"].to_string();
    assert!(faults.contains("which is damaged"), "{summary}");
    assert!(faults.contains("from the state before"), "{summary}");
}
