//! The cells' equipment on the command line: seen, asked for, and refused where
//! there is none.

use robocell_tests::assert::{nothing_started, refused};
use robocell_tests::cell::{TestCell, base};
use robocell_tests::program::{finish, robocell};

#[test]
fn more_bins_than_there_are_are_refused_with_how_many_there_are() {
    for (demo, bins, words) in [
        ("ur10-palletize", "10", ["--bins is 10", "1 to 9"]),
        ("ur10-bin-stack", "37", ["--bins is 37", "1 to 36"]),
        ("ur10-bin-stack", "0", ["--bins is 0", "1 to 36"]),
        ("franka-stack", "2", ["--bins is 2", "no bins"]),
    ] {
        let base = base();
        let said = finish(robocell(base.path(), &["run", demo, "--bins", bins]));
        refused(&said, 3, &words);
        nothing_started(base.path());
    }
}

#[test]
fn a_script_for_equipment_that_is_not_there_is_refused_with_its_line() {
    for (demo, line, words) in [
        ("franka-stack", r#""do": "drop_parts""#, "no dispenser"),
        ("ur10-palletize", r#""do": "drop_parts""#, "no dispenser"),
        ("ur10-fill-bin", r#""do": "add_bin""#, "no conveyor"),
        ("ur10-palletize", r#""do": "add_bins""#, "'add_bin'"),
        (
            "ur10-bin-stack",
            r#""do": "add_bin", "flip": true"#,
            "flipped",
        ),
        (
            "ur10-bin-stack",
            r#""do": "gripper", "to": "open", "arm": 1"#,
            "arm is 1",
        ),
        (
            "ur10-bin-stack",
            r#""do": "drag", "object": "bin_99", "to": [0, 0, 0]"#,
            "bin_",
        ),
    ] {
        let base = base();
        let dir = base.path().join("files");
        std::fs::create_dir(&dir).unwrap();
        let file = dir.join("s.jsonl");
        std::fs::write(&file, format!("\n{{\"at_s\": 1, {line}}}\n")).unwrap();
        let file = file.to_str().unwrap();
        let said = finish(robocell(base.path(), &["run", demo, "--script", file]));
        refused(&said, 3, &["s.jsonl:2", words]);
        std::fs::remove_dir_all(&dir).unwrap();
        nothing_started(base.path());
    }
}

#[test]
fn a_cell_without_equipment_says_so_when_it_is_asked_for() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    cell.wait_up();
    refused(&cell.ask(&["drop-parts"]), 3, &["no dispenser"]);
    refused(&cell.ask(&["add-bin", "--flipped"]), 3, &["no conveyor"]);
    let frame = cell.ask(&["top"]);
    assert_eq!(frame.code, 0, "{frame:?}");
    assert!(!frame.stdout.contains("equipment"), "{}", frame.stdout);
}

#[test]
fn an_arm_is_led_by_hand_only_while_the_task_does_not_lead_it() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    cell.wait_up();
    let by_hand: [&[&str]; 2] = [&["gripper", "close"], &["target", "0.4", "-0.1", "0.3"]];
    for command in by_hand {
        refused(&cell.ask(command), 3, &["robocell task pause"]);
    }
    assert_eq!(cell.ask(&["task", "pause"]).code, 0);
    for command in by_hand {
        assert_eq!(cell.ask(command).code, 0, "{command:?}");
    }
}

#[test]
fn an_answer_says_what_a_command_waits_for() {
    let cell = TestCell::start(&["franka-stack", "--headless", "--paused"]);
    cell.wait_up();
    let said = |command: &[&str], words: &[&str]| {
        let said = cell.ask(command);
        assert_eq!(said.code, 0, "{said:?}");
        for word in words {
            assert!(said.stdout.contains(word), "no {word:?} in {}", said.stdout);
        }
    };
    said(&["task", "pause"], &["task paused at 0.000 s\n"]);
    let resumes = "`robocell task resume`";
    said(
        &["task", "start"],
        &["start event given", resumes, "time is paused"],
    );
    said(&["reset"], &["scene reset", "still paused", resumes]);
    let reset = [
        "gripper open",
        "start and targets cleared",
        "default pose",
        resumes,
    ];
    said(&["task", "reset"], &reset);
}

#[test]
fn a_reset_of_the_task_lets_go_and_sends_the_arm_to_its_default_pose() {
    // What the status says of the arm at its default pose: TCP (m), or joints (rad).
    let fill_bin = ("ur10-fill-bin", "/tcp/position", vec![0.0, 0.75, 0.42]);
    let home = vec![0.012, -0.5686, 0.0, -2.8102, 0.0, 3.0366, 0.741];
    let stack = ("franka-stack", "/joint_positions", home);
    for (demo, key, wanted) in [fill_bin, stack] {
        let cell = TestCell::start(&[demo, "--headless", "--speed", "max", "--paused"]);
        cell.wait_up();
        assert_eq!(cell.ask(&["task", "start"]).code, 0);
        assert_eq!(cell.ask(&["resume"]).code, 0);
        cell.wait_status("something held", |status| {
            status["arms"][0]["holds"].is_string()
        });
        assert_eq!(cell.ask(&["task", "reset"]).code, 0);
        cell.wait_status("an arm at rest with nothing", |status| {
            let arm = &status["arms"][0];
            let found = arm.pointer(key).and_then(|found| found.as_array()).unwrap();
            let off = |(found, wanted): (&serde_json::Value, &f64)| {
                (found.as_f64().unwrap() - wanted).abs()
            };
            let mut offs = found.iter().zip(&wanted).map(off);
            status["outcome"] == "paused" && arm["holds"].is_null() && offs.all(|off| off < 0.02)
        });
    }
}

#[test]
fn top_shows_the_equipment_the_suction_and_what_was_said_before() {
    let cell = TestCell::start(&["ur10-bin-stack", "--headless", "--speed", "max", "--paused"]);
    cell.wait_up();
    assert_eq!(cell.ask(&["task", "start"]).code, 0);
    assert_eq!(cell.ask(&["step", "9000"]).code, 0);
    cell.wait_status("the end of the steps", |status| {
        status["paused"] == true && status["sim_time_s"].as_f64() > Some(8.99)
    });
    let frame = cell.ask(&["top"]);
    assert_eq!(frame.code, 0, "{frame:?}");
    for words in [
        "PAUSED",
        "suction on",
        "holds bin_01",
        "belt ",
        "bins: 1 arrived",
        "sensors ",
        "ATTACH -> ",
    ] {
        assert!(
            frame.stdout.contains(words),
            "no {words:?} in\n{}",
            frame.stdout
        );
    }
}
