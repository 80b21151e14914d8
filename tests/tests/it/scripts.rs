//! Reports about the lines of a script, and about the places of all bodies.

use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{finish, robocell};
use serde_json::{Value, json};

#[test]
fn lines_that_were_refused_are_said_and_in_the_summary() {
    let base = base();
    let script = base.path().join("script.jsonl");
    let lines = [
        r#"{"at_s": 0.1, "do": "gripper", "to": "close"}"#,
        r#"{"at_s": 0.2, "do": "task_pause"}"#,
        r#"{"at_s": 0.3, "do": "target", "position": [0.4, 0.2, 0.3]}"#,
        r#"{"at_s": 0.4, "do": "task_resume"}"#,
        r#"{"at_s": 0.45, "do": "target", "position": [0.4, 0.2, 0.3]}"#,
        r#"{"at_s": 0.5, "do": "kill", "process": "task"}"#,
    ];
    std::fs::write(&script, lines.join("\n")).unwrap();
    let script = script.display().to_string();
    for more in [&["--one-process"][..], &["--headless"]] {
        let arguments = ["run", "franka-stack", "--speed", "max", "--timeout", "1"];
        let asked = [&arguments, more, &["--json", "--script", &script]].concat();
        let said = finish(robocell(base.path(), &asked));
        let summary: Value = serde_json::from_str(said.stdout.lines().last().unwrap()).unwrap();
        let replies = summary["script_replies"].as_array().unwrap();
        let what = |reply: &Value| (reply["line"].clone(), reply["accepted"].clone());
        let whats: Vec<_> = replies.iter().map(what).collect();
        let wanted = [false, true, true, true, false, true];
        let wanted = (1..)
            .zip(wanted)
            .map(|(line, done)| (json!(line), json!(done)));
        assert_eq!(whats, wanted.collect::<Vec<_>>(), "{more:?} {summary}");
        assert_eq!(
            (&replies[0]["do"], &replies[0]["at_s"]),
            (&json!("gripper"), &json!(0.1))
        );
        for part in [
            "script line 1, gripper, at 0.100 s: refused: the task leads the arm",
            "script line 5, target, at 0.450 s: refused: the task leads the arm",
        ] {
            assert!(said.stderr.contains(part), "{}", said.stderr);
        }
    }
}

#[test]
fn status_says_where_everything_is_and_what_the_conveyor_waits_for() {
    let cell = TestCell::start(&["ur10-bin-stack", "--headless"]);
    let status = cell.wait_up();
    let arm = &status["arms"][0];
    assert_eq!(
        (&arm["name"], &arm["holds"]),
        (&json!("ur10"), &Value::Null)
    );
    let z = arm["tcp"]["position"][2].as_f64().unwrap();
    assert!((0.4..0.6).contains(&z), "{arm}");
    assert_eq!(arm["suction"]["refused"], 0);
    assert_eq!(status["conveyor"]["waits_for"], "task start");
    let text = cell.ask(&["status"]).stdout;
    for part in [
        "arm ur10: tool at -0.06",
        "holds nothing",
        "`robocell task start`",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    let status = cell.wait_up();
    let names: Vec<_> = status["objects"]
        .as_array()
        .unwrap()
        .iter()
        .map(|o| &o["name"])
        .collect();
    assert!(names.contains(&&json!("red_cube")), "{names:?}");
    assert!(cell.ask(&["status"]).stdout.contains("  red_cube"));
}
