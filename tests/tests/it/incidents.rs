//! The data kept of failures, and shown by `robocell incident`.

use std::path::Path;

use cell_record::Recording;
use robocell_tests::cell::{TestCell, base, generation};
use robocell_tests::fault::kill_and_wait;
use robocell_tests::program::{finish, robocell, wait_for};
use serde_json::Value;

/// `robocell incident ARGUMENTS --json` in `base`.
fn incident(base: &Path, arguments: &[&str]) -> Value {
    let mut all = vec!["incident"];
    all.extend(arguments);
    all.push("--json");
    finish(robocell(base, &all)).json()
}

/// Lines of the page in a recording of the last seconds, once it has the incident as well.
fn recorded_texts(cell: &TestCell) -> Vec<String> {
    let mut attempts = 0;
    let messages = wait_for("a recorded incident", || {
        attempts += 1;
        let file = cell.base().join(format!("last{attempts}.mcap"));
        let said = cell.ask(&["record", "last", "60s", &file.display().to_string()]);
        assert_eq!(said.code, 0, "{said:?}");
        let messages = Recording::open(&file).unwrap().page_messages().unwrap();
        let is_whole = |message: &Value| message["incident"]["loops"].is_array();
        messages.iter().any(is_whole).then_some(messages)
    });
    let lines = messages
        .iter()
        .filter_map(|message| message["lines"].as_array());
    let texts = lines.flatten().map(|line| line["text"].as_str().unwrap());
    texts.map(str::to_owned).collect()
}

fn looped<'a>(incident: &'a Value, process: &str) -> &'a Value {
    let loops = incident["loops"].as_array().unwrap();
    let found = loops.iter().find(|trace| trace["process"] == process);
    found.unwrap_or_else(|| panic!("no loop {process}"))
}

#[test]
fn a_killed_process_leaves_the_last_seconds_of_every_loop_and_who_came_after() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_status("a running task", |status| status["outcome"] == "running");
    kill_and_wait(&cell, "task");
    let said = wait_for("a complete incident", || {
        let all = incident(cell.base(), &[]);
        let head = all["incidents"].as_array()?.first()?.clone();
        head["complete"].as_bool()?.then_some(head)
    });
    assert_eq!(said["what"], "task was killed (SIGKILL)");
    assert_eq!(
        (&said["demo"], &said["number"]),
        (&"franka-stack".into(), &1.into())
    );
    let whole = incident(cell.base(), &["1"]);
    let events: Vec<&str> = whole["events"]
        .as_array()
        .unwrap()
        .iter()
        .map(|event| event["what"].as_str().unwrap())
        .collect();
    assert_eq!(
        events,
        ["task was killed (SIGKILL)", "task works again, start 2"]
    );
    // Both tasks are in it, and the hold of the arm between them.
    let starts = looped(&whole, "task")["generation"].as_array().unwrap();
    assert!(starts.contains(&1.into()) && starts.contains(&2.into()));
    let stops = &looped(&whole, "controller-0")["values"]["stop action"];
    let stops: Vec<f64> = serde_json::from_value(stops.clone()).unwrap();
    assert!(stops.contains(&0.0) && stops.contains(&3.0), "{stops:?}");
    for process in ["physics", "controller-0"] {
        let trace = looped(&whole, process);
        let ticks: Vec<u64> = serde_json::from_value(trace["tick"].clone()).unwrap();
        assert!(ticks.len() > 500, "{process}: {}", ticks.len());
        assert!(ticks.is_sorted(), "{process}");
        assert_eq!(trace["late_us"].as_array().unwrap().len(), ticks.len());
    }
    let printed = cell.ask(&["incident", "1"]).stdout;
    for part in [
        "Incident 1: task was killed",
        "controller-0: ",
        "▁",
        "start 1, 2",
    ] {
        assert!(printed.contains(part), "{part} in {printed}");
    }
    assert!(cell.run_dir().join("incidents/1/task.slots").is_file());
    assert_eq!(
        recorded_texts(&cell),
        ["incident 1: task was killed (SIGKILL)"]
    );
    let none = cell.ask(&["incident", "7"]);
    assert_eq!(none.code, 3, "{none:?}");
    assert!(none.stderr.contains("1 to 1 are kept"), "{none:?}");
}

#[test]
fn evidence_is_kept_before_the_successor_starts_also_when_the_launcher_is_killed() {
    let cell = TestCell::start(&["franka-stack", "--headless"]);
    let status = cell.wait_up();
    assert_eq!(generation(&status, "controller-0"), 1);
    kill_and_wait(&cell, "controller-0");
    let base = cell.crash();
    let all = incident(base.path(), &[]);
    assert_eq!(
        all["incidents"][0]["what"], "controller-0 was killed (SIGKILL)",
        "{all}"
    );
    let whole = incident(base.path(), &["1"]);
    let ticks = looped(&whole, "controller-0")["tick"].as_array().unwrap();
    assert!(!ticks.is_empty());
}

#[test]
fn a_kill_by_a_script_is_an_incident_also_in_lockstep() {
    let base = base();
    let script = base.path().join("kill.jsonl");
    let line = r#"{"at_s": 1.0, "do": "kill", "process": "task"}"#;
    std::fs::write(&script, line).unwrap();
    let script = script.display().to_string();
    let run = ["run", "franka-stack", "--headless", "--speed", "max"];
    let run = [&run[..], &["--timeout", "2", "--script", &script]].concat();
    finish(robocell(base.path(), &run));
    let all = incident(base.path(), &[]);
    let what = &all["incidents"][0]["what"];
    assert_eq!(what, "task was killed by the script", "{all}");
    // Physics waits at that tick until the launcher has killed it.
    assert_eq!(all["incidents"][0]["sim_time_s"], 1.0, "{all}");
}

#[test]
fn a_run_that_is_given_up_completes_its_incident() {
    let mut cell = TestCell::start(&["franka-stack", "--headless"]);
    cell.wait_up();
    // Given up after 6 ends within 10 s, which on a busy machine are not the first 6.
    for start in 1..=60 {
        let killed = wait_for("the next task, or the end of the run", || {
            let status = cell.status();
            let works = status.filter(|status| generation(status, "task") == start);
            let pid = works.map(|status| robocell_tests::cell::pid(&status, "task"));
            (pid.is_some() || !cell.is_running()).then_some(pid)
        });
        let Some(pid) = killed else {
            break;
        };
        cell_rt::process::kill(pid, cell_rt::process::SIGKILL).unwrap();
    }
    let said = cell.wait_end();
    assert!(said.stderr.contains("task is given up"), "{}", said.stderr);
    let all = incident(cell.base(), &[]);
    let last = all["incidents"].as_array().unwrap().last().unwrap();
    assert_eq!(last["complete"], true, "{all}");
    let whole = incident(cell.base(), &[&last["number"].to_string()]);
    let events = whole["events"].to_string();
    assert!(events.contains("task is given up"), "{events}");
}
